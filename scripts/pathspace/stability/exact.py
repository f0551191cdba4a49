"""Evaluates the paths of a log anew, with many digits, from nothing but their vertices.

    pathspace paths SCENE -i bdpt --scene-json scene.json -o paths.jsonl
    python -m pathspace.stability.exact --scene-json scene.json paths.jsonl …

f(x̄), the densities of all techniques, weights and contributions follow from the vertices' positions
and normals and the scene's parameters, with 60 digits and other formulae than the program's. The
difference to what the log says has to be explained by rounding: each factor's arguments are turned
by one unit roundoff to see what that does to it, and these effects add up along the path.

For each log there is a line of JSON on standard output:

log, paths, edges
    the file, the number of its paths, edges of the longest.
log10_p
    smallest and largest density of all techniques.
quantities
    by name: `error`, the largest relative error (null: infinite); and of the number that is nearest
    to its bound, or furthest beyond, `bound`, `ratio` of error to bound (null: infinite), and
    `at`, which it is; `loosest`, the largest of all bounds; `numbers`, how many there are;
    `beyond`, of how many of them rounding may leave no digit, which are not compared. Names: f,
    ln f, p (of each technique), ln p, w of all (the weight of each), Σ w, w and w f/(n p) (what the
    integrator itself computed), f/p, and P(emitter), the choice of emitters, absolute.
skipped
    paths that cannot be evaluated, by the reason.
holds
    true if no error is above its bound.

Exit status: 0 all hold; 1 some do not; 2 wrong arguments or files.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from .compare import Comparison, LogError, compare
from .scene import Scene


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m pathspace.stability.exact",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("logs", nargs="+", type=Path, metavar="LOG.jsonl")
    parser.add_argument(
        "--scene-json",
        type=Path,
        metavar="SCENE.json",
        help="of all logs; default: beside each log, with its name and the ending .json",
    )
    parser.add_argument(
        "--light-selection",
        choices=("power", "uniform"),
        default="power",
        help="how emitters are chosen, as given to `pathspace paths`",
    )
    options = parser.parse_args(arguments)
    try:
        holds = True
        for log in options.logs:
            parameters = options.scene_json or log.with_suffix(".json")
            scene = read(parameters, lambda text: Scene.of(json.loads(text)))
            lines = read(log, lambda text: [json.loads(line) for line in text.splitlines()])
            record = evaluate(log, lines, scene, uniform=options.light_selection == "uniform")
            print(json.dumps(record, ensure_ascii=False), flush=True)
            holds = holds and record["holds"]
    except LogError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return 0 if holds else 1


def read(path: Path, parse: Any) -> Any:  # noqa: ANN401
    """Parse a file; say where it is wrong."""
    try:
        return parse(path.read_text())
    except OSError as error:
        raise LogError(f"{path}: {error.strerror}") from error
    except NotImplementedError as error:
        raise LogError(f"{path}: {error}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise LogError(f"{path}: is no file of `pathspace paths`: {error}") from error


def evaluate(
    log: Path, lines: list[dict[str, Any]], scene: Scene, *, uniform: bool
) -> dict[str, Any]:
    """Compare a log; return what is printed."""
    try:
        comparison: Comparison = compare(lines, scene)
    except LogError as error:
        raise LogError(f"{log}: {error}") from error
    except (KeyError, TypeError, IndexError) as error:
        raise LogError(f"{log}: is no log of schema 4 of this scene: {error!r}") from error
    if not any(isinstance(emitter, NotImplementedError) for emitter in scene.emitters):
        comparison.of("P(emitter)").add(*scene.choice_error(uniform=uniform), "")
    return {
        "log": str(log),
        "paths": comparison.paths,
        "edges": comparison.longest,
        "log10_p": comparison.log10_p if comparison.paths else None,
        "quantities": {name: q.record() for name, q in comparison.quantities.items()},
        "skipped": comparison.skipped,
        "holds": comparison.holds,
    }


if __name__ == "__main__":
    sys.exit(main())
