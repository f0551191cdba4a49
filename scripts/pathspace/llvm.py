"""Finds an LLVM library that Mitsuba's `llvm_*` variants work with.

Some versions abort the whole process (LLVM 15: `Cannot select: fminimum`), so each is tried in a
process of its own.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from .files import write_json

HOW_TO_GET = (
    "to get llvm_ad_rgb, install LLVM 16 or newer (Debian, Ubuntu: apt-get install libllvm19)"
)
TRIAL_SECONDS = 120.0

_FOLDERS = (
    "/usr/lib/*-linux-gnu",
    "/usr/lib/llvm-*/lib",
    "/usr/lib64",
    "/usr/lib64/llvm*/lib*",
    "/usr/lib",
    "/usr/local/lib",
    "/opt/homebrew/opt/llvm*/lib",
    "/usr/local/opt/llvm*/lib",
)
_NAME = re.compile(r"^libLLVM(?:-?(\d+)[\d.]*)?\.(?:so|dylib)(?:\.(\d+)[\d.]*)?$")
_TRIAL = """
import mitsuba as mi, numpy as np
mi.set_variant("llvm_ad_rgb")
scene = {"type": "scene", "i": {"type": "path", "max_depth": 3},
         "c": {"type": "perspective", "f": {"type": "hdrfilm", "width": 8, "height": 8}},
         "s": {"type": "sphere", "center": [0, 0, 4]}, "l": {"type": "constant"}}
image = np.array(mi.render(mi.load_dict(scene), spp=4))
assert np.isfinite(image).all() and image.mean() > 0
"""


def version_of(library: Path) -> int:
    """Major version that a library's name states, looking behind links; 0 if none does."""
    for name in (library.name, library.resolve().name):
        # In `libLLVM-15.so.1` and in `libLLVM.so.19.1` alike the version is the first number.
        if (match := _NAME.match(name)) and (number := match[1] or match[2]):
            return int(number)
    return 0


def candidates() -> list[Path]:
    """Every LLVM library on this machine, the newest first; the user's choice before all."""
    found = [path for folder in _FOLDERS for path in Path("/").glob(folder[1:] + "/libLLVM*")]
    try:
        listing = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True, check=False)
        found += [Path(p) for p in re.findall(r"=> (\S*/libLLVM\S*)", listing.stdout)]
    except OSError:
        pass
    real = {path.resolve(): version_of(path) for path in found if _NAME.match(path.name)}
    newest_first = sorted((p for p in real if p.is_file()), key=lambda p: (-real[p], str(p)))
    if chosen := os.environ.get("DRJIT_LIBLLVM_PATH"):
        return [Path(chosen), *(p for p in newest_first if p != Path(chosen))]
    return newest_first


def works(library: Path) -> bool | None:
    """Render with this library in another process; `None` where that took too long to tell."""
    environment = os.environ | {"DRJIT_LIBLLVM_PATH": str(library)}
    # An aborting process may leave a core file in its folder.
    with tempfile.TemporaryDirectory() as folder:
        try:
            trial = subprocess.run(
                [sys.executable, "-c", _TRIAL],
                env=environment,
                cwd=folder,
                capture_output=True,
                timeout=TRIAL_SECONDS,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return None
    return trial.returncode == 0


def cache_file() -> Path:
    """Where verdicts are kept: in the virtual environment, or else in the user's cache."""
    if sys.prefix != sys.base_prefix:
        return Path(sys.prefix) / "pathspace-llvm.json"
    cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(cache) / "pathspace" / "llvm.json"


def find() -> Path | None:
    """Return the newest LLVM library that works, or `None`.

    Verdicts are cached by path, time of change and version of Mitsuba.
    """
    path = cache_file()
    try:
        verdicts: dict[str, bool] = json.loads(path.read_text())
    except (OSError, ValueError):
        verdicts = {}
    for library in candidates():
        if not library.is_file():
            continue
        key = f"{library} {library.stat().st_mtime_ns} mitsuba {version('mitsuba')}"
        if key not in verdicts:
            verdict = works(library)
            if verdict is None:
                continue
            verdicts[key] = verdict
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
                write_json(path, verdicts)
            except OSError:
                pass  # It will be tried again, which costs seconds only.
        if verdicts[key]:
            return library
    return None
