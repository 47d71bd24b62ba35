"""The program `carom` that comes with the package, also available as `python -m carom`."""

import sys

from carom import _carom


def main() -> None:
    """Runs the program with the command-line arguments, and exits with its exit code."""
    sys.exit(_carom.main(["carom", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
