"""``python -m vcmm``: the command line, for environments whose scripts are not on the path."""

from vcmm.face.cli import main

if __name__ == "__main__":
    main()
