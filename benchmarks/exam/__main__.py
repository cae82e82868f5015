import os
import sys

# before numpy: threads of the matrix library cost more than they give where several cases run side by side
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from benchmarks.exam.run import main

if __name__ == "__main__":
    sys.exit(main())
