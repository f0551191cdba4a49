"""Mitsuba's side of `pathspace parity`: scene files, its images, and its values point by point.

    python -m pathspace.parity.run --out DIR [--passes N] [--seed S] [--threads N] [--full]
        [--list] [--no-points] [FEATURE…]

One process serves all cases, since importing Mitsuba and compiling kernels takes longer than
rendering. For each case it writes into DIR/GROUP/FEATURE

scene.xml
    The scene, with `path` and its `max_depth`; what it refers to is in DIR/GROUP beside it.
mitsuba-INTEGRATOR.npy
    Independent passes: float32, passes × height × width × 3, top row first, in `llvm_ad_rgb` where
    that works.
points.json
    Queries and answers of `scalar_rgb`, see `points`.

DIR/cases.json lists all cases with what a comparison has to know. On stderr there is a line of
JSON for each case that is done, `{"case", "integrators", "seconds"}`, or `{"case", "failed"}` where
Mitsuba has refused it. Anything else there is a message for people. Exit status: 0 done; 1 failed;
2 wrong arguments, such as an unknown feature; 130 interrupted.
"""

import argparse
import os
import shutil
import signal
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from pathspace import llvm
from pathspace.files import write_array, write_json
from pathspace.seeds import PassSeeds

from .case import Case
from .catalogue import chosen
from .points import write_points

SPP = 64
"""Samples per pixel of a pass."""
LIGHT_PATHS = 8
"""Light paths for each of them: few come to the camera."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    options = parse(arguments)
    try:
        cases = chosen(options.features, full=options.full)
    except LookupError as error:
        print(error.args[0], file=sys.stderr)
        return 2
    if options.list:
        print("\n".join(case.name for case in cases))
        return 0
    library = llvm.find()
    if library is not None:
        os.environ["DRJIT_LIBLLVM_PATH"] = str(library)
    prepare(options.out, cases, full=options.full)
    stop = False

    def interrupted(*_: object) -> None:
        nonlocal stop
        stop = True

    signal.signal(signal.SIGINT, interrupted)
    signal.signal(signal.SIGTERM, interrupted)
    for case in cases:
        if stop:
            return 130
        start = time.perf_counter()
        try:
            integrators = serve(case, options, jit=library is not None)
        except Exception as error:
            tell(case=case.name, failed=" ".join(str(error).split()))
        else:
            tell(case=case.name, integrators=integrators, seconds=time.perf_counter() - start)
    return 0


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """Read the command line, as the module's documentation describes it."""
    parser = argparse.ArgumentParser(prog="python -m pathspace.parity.run")
    add = parser.add_argument
    add("features", nargs="*", metavar="FEATURE")
    add("--out", type=Path, required=True)
    add("--passes", type=int, default=16)
    add("--seed", type=int, default=0)
    add("--threads", type=int, default=os.cpu_count() or 1)
    add("--full", action="store_true", help="both integrators of Mitsuba wherever they apply")
    add("--list", action="store_true", help="list the features and end")
    add("--no-points", action="store_true", help="images alone")
    return parser.parse_args(arguments)


def tell(**values: Any) -> None:  # noqa: ANN401
    """Write a line of JSON to stderr."""
    import json

    print(json.dumps(values), file=sys.stderr, flush=True)


def prepare(out: Path, cases: list[Case], *, full: bool) -> None:
    """Write the scene files, what they refer to, and the list of cases."""
    import mitsuba as mi

    from .assets import write_assets

    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    assets = out / "assets"
    assets.mkdir(parents=True, exist_ok=True)
    write_assets(assets)
    entries = []
    for case in cases:
        folder = out / case.name
        folder.mkdir(parents=True, exist_ok=True)
        for path in [*folder.glob("*.npy"), *folder.glob("*.json"), *folder.glob("*.exr")]:
            path.unlink()
        for asset in assets.iterdir():
            # A scene may refer to nothing outside its folder.
            if f'"{asset.name}"' in case.text:
                shutil.copyfile(asset, folder / asset.name)
        if case.file is None:
            (folder / "scene.xml").write_text(case.text)
        entries.append(
            {
                "name": case.name,
                "scene": str(case.file or (folder / "scene.xml").resolve()),
                "parameters": case.parameters,
                "independent": str(case.independent) if case.independent else None,
                "max_depth": case.max_depth,
                "border": case.border,
                "effort": case.effort,
                "integrators": integrators_of(case, full=full),
                "pdf": case.pdf,
                "table": case.table,
                "fit": case.fit,
            }
        )
    write_json(out / "cases.json", entries)


def integrators_of(case: Case, *, full: bool) -> list[str]:
    """Name Mitsuba's integrators that render a case."""
    if case.file is not None:
        return ["path"]
    can = 'type="perspective"' in case.text or 'type="thinlens"' in case.text
    return ["path", "ptracer"] if can and (full or case.particles) else ["path"]


def serve(case: Case, options: argparse.Namespace, *, jit: bool) -> list[str]:
    """Render a case and ask for its values; return the names of the integrators."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb" if jit else "scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    dr.set_thread_count(options.threads)
    folder = options.out / case.name
    file = str(case.file or folder / "scene.xml")
    scene: Any = mi.load_file(file, **dict(case.parameters))
    mi.logger().clear_appenders()
    width, height = (int(n) for n in scene.sensors()[0].film().crop_size())
    names = integrators_of(case, full=options.full)
    for name in names:
        integrator: Any = mi.load_dict({"type": name, "max_depth": case.max_depth})
        seeds = PassSeeds(options.seed, width, height, scalar=not jit)
        spp = SPP * case.effort * (LIGHT_PATHS if name == "ptracer" else 1)
        images = [
            np.array(integrator.render(scene, seed=seeds(i), spp=spp))[..., :3]
            for i in range(options.passes)
        ]
        write_array(folder / f"mitsuba-{name}.npy", np.stack(images).astype(np.float32))
    if not options.no_points and case.file is None:
        mi.set_variant("scalar_rgb")
        write_points(folder / "points.json", case, mi.load_file(file))
    return names


if __name__ == "__main__":
    sys.exit(main())
