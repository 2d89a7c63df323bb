"""Files that appear whole or not at all."""

from contextlib import suppress
from pathlib import Path

from recorder.exceptions import UnwritableOutput


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a text or bytes, the folder too where there is none. Raises UnwritableOutput."""
    part = path.with_name(path.name + ".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_bytes(content.encode() if isinstance(content, str) else content)
        part.replace(path)
    except OSError as error:
        raise UnwritableOutput(path, f"cannot be written ({error.strerror})", "choose another place with -o") from None
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)
