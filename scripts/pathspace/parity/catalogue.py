"""All cases by name."""

from pathlib import Path

from . import materials, others
from .case import Case

ELSEWHERE = Path("../shared/scenes/mitsuba")
"""Whole scenes by others, where somebody has put them."""
WHOLE = {"cornell-box": (128, 128), "veach-bidir": (128, 128), "veach-mis": (160, 90)}
"""Their names, and films of theirs that take minutes."""


def whole_scenes() -> list[Case]:
    """List the scenes by others that are there."""
    found = []
    for name, (width, height) in WHOLE.items():
        folder = ELSEWHERE / f"bitterli-{name}"
        if not (folder / "scene.xml").is_file():
            continue
        parameters = (("integrator", "path"), ("resx", str(width)), ("resy", str(height)))
        image = folder / "TungstenRender.exr"
        # This copy of the plates ends paths after 3 edges, and the image beside it does not.
        depth, independent = {
            "cornell-box": (30, image),
            "veach-bidir": (7, image),
            "veach-mis": (3, None),
        }[name]
        found.append(
            Case(
                f"scene/{name}",
                "",
                depth,
                border=1,
                file=(folder / "scene.xml").resolve(),
                parameters=parameters,
                independent=independent.resolve() if independent else None,
            )
        )
    return found


def all_cases(*, full: bool) -> list[Case]:
    """List them, in the order of tables."""
    return materials.cases() + others.cases() + (whole_scenes() if full else [])


def chosen(words: list[str], *, full: bool) -> list[Case]:
    """List the cases that words name: how names begin, or a part of the feature; all for none."""
    cases = all_cases(full=full)
    if not words:
        return cases
    for word in words:
        if not any(matches(word, case.name, cases) for case in cases):
            raise LookupError(f"no feature is called {word!r}")
    return [case for case in cases if any(matches(word, case.name, cases) for word in words)]


def matches(word: str, name: str, cases: list[Case]) -> bool:
    """Tell whether a word names a case; a whole name names no other."""
    if any(case.name == word for case in cases):
        return name == word
    return name.startswith(word) or word in name.split("/", 1)[1]
