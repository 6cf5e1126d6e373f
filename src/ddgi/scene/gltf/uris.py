"""Bytes outside the document: data URIs, and files, which must lie in the scene's own folder."""

from __future__ import annotations

import base64
import binascii
from pathlib import Path
from urllib.parse import unquote, unquote_to_bytes

from ddgi.errors import SceneError
from ddgi.scene.beside import SCHEME, file_beside, shown


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
        raise SceneError(f"{owner}: {shown(uri)} cannot be read: {error.strerror}") from error


def local_path(uri: str, folder: Path, owner: str) -> Path:
    """The file that a URI means.

    Raises:
        SceneError: It does not exist, or does not lie in `folder`.
    """
    if SCHEME.match(uri):
        raise SceneError(f"{owner}: {shown(uri)} is neither a file beside the scene nor a data URI")
    try:
        name = unquote(uri, errors="strict")
    except UnicodeDecodeError as error:
        raise SceneError(f"{owner}: the path {shown(uri)} is not UTF-8") from error
    return file_beside(name, folder, owner, written=uri)


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
