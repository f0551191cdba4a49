"""Prints as JSON what Mitsuba can do here: version, variants, and the LLVM library that works.

python -m pathspace.mitsuba_probe
"""

import json
import sys
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from . import llvm


def probe() -> dict[str, Any]:
    """Version of Mitsuba, usable variants, path of the LLVM library or `None`."""
    library = llvm.find()
    return {
        "mitsuba": version("mitsuba"),
        "variants": {"scalar_rgb": True, "llvm_ad_rgb": library is not None},
        "llvm": None if library is None else str(library),
    }


def main() -> int:
    """Print the result of `probe`; without LLVM, say on stderr how to get it."""
    try:
        result = probe()
    except PackageNotFoundError:
        print("mitsuba is not installed; run scripts/setup", file=sys.stderr)
        return 1
    print(json.dumps(result, indent=2))
    if result["llvm"] is None:
        print(llvm.HOW_TO_GET, file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
