"""Who may ask for what: exact hosts and origins, two tokens, and what a browser may load."""

import hmac
import secrets
from typing import NamedTuple

TOKEN_BYTES = 16

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' blob:; frame-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors {ancestors}"
)

HEADERS = {
    "X-Content-Type-Options": "nosniff",
    # Not `no-referrer`: with it a browser hides the origin of a form as well.
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
    "Cache-Control": "no-store",
}


def policy(*, framed: bool) -> str:
    """Return the Content-Security-Policy of a page; `framed`: our own page may show it inside."""
    return POLICY.format(ancestors="'self'" if framed else "'none'")


class Tokens(NamedTuple):
    """The two keys to a page, 128 random bits each.

    Parameters
    ----------
    look : str
        Opens everything that changes nothing.
    steer : str or None
        Opens the gains as well; None: they are not opened to anybody.
    """

    look: str
    steer: str | None

    @classmethod
    def draw(cls, *, steer: bool) -> "Tokens":
        """Draw new ones."""
        look, other = secrets.token_urlsafe(TOKEN_BYTES), secrets.token_urlsafe(TOKEN_BYTES)
        return cls(look, other if steer else None)

    def rights(self, token: str) -> tuple[bool, bool]:
        """Return whether a token permits to look and to steer; it takes as long for any token."""
        told = token.encode(errors="replace")
        steer = (self.steer or secrets.token_urlsafe(TOKEN_BYTES)).encode()
        looks = hmac.compare_digest(told, self.look.encode())
        steers = hmac.compare_digest(told, steer)
        return looks or steers, steers


class Gate:
    """The names under which a server on loopback may be asked, and from which pages.

    A page of another site has another origin; one whose name was made to point here (DNS
    rebinding) names itself as the host.

    Parameters
    ----------
    port : int
        That the server listens on.
    """

    def __init__(self, port: int) -> None:
        self.hosts = frozenset(f"{name}:{port}" for name in ("127.0.0.1", "localhost"))
        self.origins = frozenset(f"http://{host}" for host in self.hosts)

    def knows_host(self, hosts: list[str]) -> bool:
        """Return whether a request names one host, which is this one."""
        return len(hosts) == 1 and hosts[0] in self.hosts

    def knows_origin(self, origins: list[str], host: str) -> bool:
        """Return whether a request comes from our own page, as that host has served it."""
        return len(origins) == 1 and origins[0] in self.origins and origins[0] == f"http://{host}"
