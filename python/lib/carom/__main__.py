"""The program `carom`, which the package brings: also `python -m carom`."""

import sys

from carom import _carom


def main() -> None:
    """Does what was typed, and ends with the program's exit code."""
    sys.exit(_carom.main(["carom", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
