"""Hashes of a completion and its expected error, by machine code and in numpy; printed where this file is run."""

from hashlib import sha256
from unittest.mock import patch

import ilf
from ilf._runtime import compiling
from tests.bench.samples import scaled


def bits() -> list[str]:
    """In this size, a banded factorisation on two threads of BLAS differs from one on one in the last bits."""
    found = []
    for machine_code in (compiling.is_compiled(), False):
        with patch.object(compiling, "is_compiled", lambda machine_code=machine_code: machine_code):
            result = ilf.complete(scaled((240, 180)), mode="fill+denoise")
            found += [sha256(values).hexdigest() for values in (result.depth, ilf.expected_error(result))]
    return found


if __name__ == "__main__":
    print(*bits())
