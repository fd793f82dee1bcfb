"""The command line, `rangegrasp`, also as `python -m rangegrasp`."""
import signal
import sys

from . import _core


def main() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Python would note Ctrl-C, and wait until the command has ended
    sys.exit(_core.main(["rangegrasp", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
