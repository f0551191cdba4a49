"""The command."""

import argparse
import sys
from pathlib import Path

from pathspace.experiment import LoadError, load

from . import __doc__ as description
from .page import write_report


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m pathspace.report",
        description=description,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of an experiment")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="default: report.html in DIR"
    )
    parser.add_argument("--no-images", action="store_true", help="leave out the viewer of images")
    options = parser.parse_args(arguments)
    output = options.output or options.folder / "report.html"
    try:
        write_report(load(options.folder), output, images=not options.no_images)
    except (LoadError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    print(output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
