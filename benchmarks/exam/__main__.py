import sys

from benchmarks.exam.run import main

sys.exit(main())
