"""What `make lint` runs: mypy over both packages under the name that one imports, errors counted by room.

`package-dir` in pyproject.toml maps folders to names, which mypy does not read: a folder of links shows it the same.
Where a room has no error it may have none; of all others together there are MOST, a number that only falls.
"""

import os
import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
CLEAN = (
    "recorder",
    "processing/batch",
    "processing/cli",
    "processing/errors.py",
    "processing/kernels",
    "processing/pipeline.py",
    "processing/reconstruction",
    "processing/registration",
    "processing/results",
    "processing/settings.py",
    "processing/steps.py",
    "processing/surface",
    "processing/timing.py",
)
MOST = 0


def check_types() -> list[str]:
    """The lines of mypy's errors, with paths from the root of the project."""
    with tempfile.TemporaryDirectory() as folder:
        package = Path(folder) / "orbitscan"
        package.mkdir()
        for name in ("recorder", "processing"):
            (package / name).symlink_to(ROOT / name, target_is_directory=True)
        (package / "__init__.py").symlink_to(ROOT / "processing" / "api" / "__init__.py")
        options = ["--config-file", str(ROOT / "pyproject.toml"), "--cache-dir", str(ROOT / ".mypy_cache")]
        command = [sys.executable, "-m", "mypy", *options, "--python-executable", sys.executable, "-p", "orbitscan"]
        found = subprocess.run(
            command, cwd=folder, env=os.environ | {"MYPYPATH": folder}, capture_output=True, text=True, check=False
        )
    if found.returncode not in (0, 1):
        raise SystemExit(found.stdout + found.stderr)
    lines = [re.sub(r"^.*?orbitscan/", "", line) for line in found.stdout.splitlines() if ": error: " in line]
    return sorted(lines)


def main() -> None:
    """Print the errors; exit status 1 where a clean room has one, or the others' number is not MOST."""
    errors = check_types()
    unclean = [line for line in errors if line.startswith(CLEAN)]
    rest = [line for line in errors if not line.startswith(CLEAN)]
    if unclean:
        sys.exit("\n".join([*unclean, "these rooms have no type errors; mend them"]))
    if len(rest) > MOST:
        sys.exit("\n".join([*rest, f"{len(rest)} type errors, {MOST} before: mend what is new"]))
    rooms = Counter("/".join(Path(line.split(":")[0]).parts[:2]) for line in rest)
    print(f"types: {len(rest)} errors" + "".join(f", {room} {count}" for room, count in sorted(rooms.items())))
    if len(rest) < MOST:
        sys.exit(f"the number only falls: set MOST in tests/types.py to {len(rest)}")


if __name__ == "__main__":
    main()
