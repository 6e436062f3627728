"""The command `subskin`, also as `python -m subskin`."""

import sys


def run() -> int:
    """Run the command line; Ctrl-C stops it in one line even while its modules are read."""
    try:
        from .cli import main

        return main()
    except KeyboardInterrupt:
        print("subskin: stopped", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(run())
