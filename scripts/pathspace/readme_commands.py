"""Runs every command that a Markdown file shows, so that none of them is wrong.

python -m pathspace.readme_commands README.md

Commands are the lines of blocks marked `sh`, run one after the other from the file's folder. The
one that calls this program, `scripts/test`, is left out.
"""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

CALLER = "scripts/test"


def commands(text: str) -> Iterator[str]:
    """Yield the lines of all `sh` blocks, comments left out."""
    inside = False
    for line in text.splitlines():
        if line.startswith("```"):
            inside = line.strip() == "```sh"
        elif inside and (command := line.split(" #")[0].strip()):
            yield command


def main() -> int:
    """Run the commands of the file named on the command line; stop at the first that fails."""
    file = Path(sys.argv[1])
    for command in commands(file.read_text(encoding="utf-8")):
        if command.startswith(CALLER):
            continue
        print(f"$ {command}", flush=True)
        status = subprocess.run(["bash", "-c", command], cwd=file.parent or None).returncode
        if status != 0:
            print(f"{file}: `{command}` ended with exit code {status}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
