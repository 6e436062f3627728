"""The secret of the studio on this machine: a page is let in again when the server was started again."""

from __future__ import annotations

import os
import secrets
from pathlib import Path

__all__ = ["kept_secret"]

_LENGTH = 32


def kept_secret() -> str:
    """The secret, made where there is none; a new one each time where it cannot be kept.

    It lies in a folder of the user's, readable by the user alone.
    """
    file = _folder() / "studio.key"
    fresh = secrets.token_urlsafe(_LENGTH)
    try:
        file.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        if file.exists() and not (os.name == "posix" and file.stat().st_mode & 0o077):
            kept = file.read_text("ascii").strip()
            if len(kept) >= _LENGTH:
                return kept
        file.unlink(missing_ok=True)
        with os.fdopen(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as out:
            out.write(fresh)
    except (OSError, UnicodeDecodeError):
        pass
    return fresh


def _folder() -> Path:
    kept = os.environ.get("LOCALAPPDATA") if os.name == "nt" else os.environ.get("XDG_STATE_HOME")
    return (Path(kept) if kept else Path.home() / ".local" / "state") / "subskin"
