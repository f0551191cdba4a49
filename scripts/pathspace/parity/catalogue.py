"""All cases by name."""

from . import materials, others
from .case import Case


def all_cases() -> list[Case]:
    """List them, in the order of tables."""
    return materials.cases() + others.cases()


def chosen(words: list[str]) -> list[Case]:
    """List the cases that words name: GROUP, GROUP/FEATURE, or a part of it; all for none."""
    cases = all_cases()
    if not words:
        return cases
    for word in words:
        if not any(matches(word, case.name) for case in cases):
            raise LookupError(f"no feature is called {word!r}")
    return [case for case in cases if any(matches(word, case.name) for word in words)]


def matches(word: str, name: str) -> bool:
    """Tell whether a word names a case."""
    return name == word or name.startswith(word.rstrip("/") + "/") or (
        word in name.split("/", 1)[1]
    )
