"""What a conversion may take for a file that somebody else has made."""
import resource

SECONDS, BYTES = 300, 16 << 30


def put_limits() -> None:
    """Limits for this process; smaller ones that it has already stay."""
    for kind, most in ((resource.RLIMIT_CPU, SECONDS), (resource.RLIMIT_AS, BYTES)):
        _, hard = resource.getrlimit(kind)
        least = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(kind, (least, hard))
