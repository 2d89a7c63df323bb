"""What `make lint` runs: mypy over both packages, under the name that one imports; it finds no error.

`package-dir` in pyproject.toml maps folders to names, which mypy does not read: a folder of links shows it the same.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]


def main() -> int:
    """Print what mypy says; its exit status."""
    with tempfile.TemporaryDirectory() as folder:
        package = Path(folder) / "orbitscan"
        package.mkdir()
        for name in ("recorder", "processing"):
            (package / name).symlink_to(ROOT / name, target_is_directory=True)
        (package / "__init__.py").symlink_to(ROOT / "processing" / "api" / "__init__.py")
        options = ["--config-file", str(ROOT / "pyproject.toml"), "--cache-dir", str(ROOT / ".mypy_cache")]
        command = [sys.executable, "-m", "mypy", *options, "--python-executable", sys.executable, "-p", "orbitscan"]
        return subprocess.run(command, cwd=folder, env=os.environ | {"MYPYPATH": folder}, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
