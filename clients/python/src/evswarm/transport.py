"""Requests to a server: address and token from the environment, refusals as exceptions."""

from __future__ import annotations

import ipaddress
import os
import time
from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import urlsplit

import httpx

from evswarm.errors import ConnectionFailed, ServerBusy, problem

DEFAULT_SERVER = "http://127.0.0.1:8080"
PAGE = 200
"""Items asked for at once; the most that the server gives."""
BUSY_WAIT_S = 30.0
"""Longest that a request that changes nothing is repeated for while the server is busy."""


class Transport:
    """One server. Connections are kept and may be used from several threads."""

    def __init__(self, server: str | None, token: str | None, timeout_s: float):
        self.server = (server or os.environ.get("EVSWARM_SERVER") or DEFAULT_SERVER).rstrip("/")
        token = token or os.environ.get("EVSWARM_TOKEN")
        headers = {"accept": "application/json", "user-agent": "evswarm-python"}
        if token:
            headers["authorization"] = f"Bearer {token}"
        self._client = httpx.Client(
            base_url=self.server,
            headers=headers,
            timeout=timeout_s,
            # A server on this machine is reached directly, whatever proxy the environment names.
            trust_env=not _is_loopback(self.server),
        )

    def close(self) -> None:
        self._client.close()

    def get(self, path: str, params: Mapping[str, Any] | None = None) -> httpx.Response:
        """Reads; while the server is busy it is asked again, up to half a minute."""
        give_up = time.monotonic() + BUSY_WAIT_S
        while True:
            try:
                return self.request("GET", path, params=params)
            except ServerBusy as busy:
                wait_s = busy.retry_after_s or 1.0
                if time.monotonic() + wait_s > give_up:
                    raise
                time.sleep(wait_s)

    def json(self, path: str, params: Mapping[str, Any] | None = None) -> Any:
        return self.get(path, params).json()

    def pages(self, path: str, params: Mapping[str, Any] | None = None) -> Iterator[dict[str, Any]]:
        """The items of a list, page after page."""
        query: dict[str, Any] = {"limit": PAGE, **(params or {})}
        while True:
            page = self.json(path, query)
            yield from page["items"]
            if page.get("next") is None:
                return
            query["cursor"] = page["next"]

    def request(
        self,
        method: str,
        path: str,
        *,
        params: Mapping[str, Any] | None = None,
        json: Any = None,
        headers: Mapping[str, str] | None = None,
    ) -> httpx.Response:
        try:
            answer = self._client.request(method, path, params=params, json=json, headers=headers)
        except httpx.HTTPError as error:
            raise ConnectionFailed(f"no answer from {self.server}: {error}") from error
        if answer.is_success:
            return answer
        raise problem(answer.status_code, _document(answer), answer.headers.get("retry-after"))


def _document(answer: httpx.Response) -> Mapping[str, Any]:
    try:
        document = answer.json()
    except ValueError:
        document = None
    if isinstance(document, dict):
        return document
    return {"title": answer.reason_phrase, "detail": answer.text[:500]}


def _is_loopback(url: str) -> bool:
    host = urlsplit(url).hostname or ""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
