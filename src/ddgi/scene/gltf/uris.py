"""Bytes outside the document: data URIs, and files, which must lie in the scene's own folder."""

from __future__ import annotations

import base64
import binascii
import re
from pathlib import Path
from urllib.parse import unquote, unquote_to_bytes

from ddgi.errors import SceneError

SCHEME = re.compile(r"^[A-Za-z][A-Za-z0-9+.-]*:")
SHOWN = 60
"""Characters of a URI that messages show."""


def read_uri(uri: str, folder: Path, owner: str) -> bytes:
    """What a URI stands for.

    Args:
        uri: A data URI, or the path of a file, relative to `folder` and percent-encoded.
        folder: The folder of the scene; files outside are refused, through links too.
        owner: Whose URI it is, for messages.

    Raises:
        SceneError: It leads out of the folder, is of another kind, or cannot be read.
    """
    if uri[:5].lower() == "data:":
        return _data(uri, owner)
    path = local_path(uri, folder, owner)
    try:
        return path.read_bytes()
    except OSError as error:
        raise SceneError(f"{owner}: {_shown(uri)} cannot be read: {error.strerror}") from error


def local_path(uri: str, folder: Path, owner: str) -> Path:
    """The file that a URI means.

    Raises:
        SceneError: It does not exist, or does not lie in `folder`.
    """
    if SCHEME.match(uri):
        raise SceneError(f"{owner}: {_shown(uri)} is neither a file beside the scene nor a data URI")
    try:
        name = unquote(uri, errors="strict").replace("\\", "/")  # as exporters on Windows write paths
    except UnicodeDecodeError as error:
        raise SceneError(f"{owner}: the path {_shown(uri)} is not UTF-8") from error
    outside = SceneError(f"{owner}: {_shown(uri)} leads out of the scene's folder, which is not allowed")
    if name.startswith("/") or SCHEME.match(name):
        raise outside
    if not name or not name.isprintable():
        raise SceneError(f"{owner}: {_shown(uri)!r} is not the path of a file")
    try:
        path = (folder / name).resolve()
        inside = path.is_relative_to(folder.resolve())
        found = path.is_file()
    except (OSError, RuntimeError) as error:  # names too long, links in a circle
        raise SceneError(f"{owner}: {_shown(uri)} cannot be found") from error
    if not inside:
        raise outside
    if not found:
        raise SceneError(f"{owner}: file not found: {_shown(uri)}")
    return path


def _data(uri: str, owner: str) -> bytes:
    head, comma, body = uri.partition(",")
    if not comma:
        raise SceneError(f"{owner}: a data URI without data")
    if not head.lower().endswith(";base64"):
        return unquote_to_bytes(body)
    try:
        return base64.b64decode(unquote_to_bytes(body), validate=True)
    except binascii.Error as error:
        raise SceneError(f"{owner}: its data URI is not base64: {error}") from error


def _shown(uri: str) -> str:
    text = uri if uri.isprintable() else repr(uri)
    return text if len(text) <= SHOWN else text[:SHOWN] + "..."
