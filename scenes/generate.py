#!/usr/bin/env python3
"""Writes the scenes of this folder: `scenes/NAME/scene.gltf` and `scene.bin`."""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path

from gltf_writer import GltfScene

HERE = Path(__file__).resolve().parent
SCENES = ("cornell_box", "veach_mis", "hidden_lamps", "glass_caustic", "enclosure")


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "scene", nargs="*", help="which to write (default: all): " + ", ".join(SCENES)
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="write nothing; fail where a file differs from what would be written",
    )
    arguments = parser.parse_args()
    names = arguments.scene or SCENES
    if unknown := [name for name in names if name not in SCENES]:
        parser.error(f"no scene named {', '.join(unknown)}; there are {', '.join(SCENES)}")

    stale = []
    for name in names:
        scene: GltfScene = importlib.import_module(f"{name}.generate").build()
        for file, content in scene.files().items():
            path = HERE / name / file
            if path.is_file() and path.read_bytes() == content:
                continue
            stale.append(path)
            if not arguments.check:
                path.write_bytes(content)
                print(f"wrote {path}")
        if not arguments.check:
            print(f"{name}: {scene.triangles} triangles, {scene.spheres} spheres")
    if arguments.check and stale:
        for path in stale:
            print(f"{path} differs from what its generator writes: run {__file__}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
