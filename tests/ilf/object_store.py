"""A stand-in for S3 on this machine, for tests and measurements of addresses."""

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager

SECRET = "wJalrXUtnFEMI/K7MDENG/bPxRfiCY"


@contextmanager
def object_store() -> Iterator[dict[str, str]]:
    """Run a server of S3 with the bucket `bucket`; provides the environment with which its drivers find it.

    Raises
    ------
    ImportError
        If moto or s3fs is not installed.
    """
    import boto3
    import s3fs  # noqa: F401
    from moto.server import ThreadedMotoServer

    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    try:
        host, port = server.get_host_and_port()
        settings = {
            "AWS_ENDPOINT_URL": f"http://{host}:{port}",
            "AWS_ACCESS_KEY_ID": "AKIAIOSFODNN7EXAMPLE",
            "AWS_SECRET_ACCESS_KEY": SECRET,
            "AWS_DEFAULT_REGION": "us-east-1",
        }
        before = {name: os.environ.get(name) for name in settings}
        os.environ.update(settings)
        try:
            boto3.client("s3").create_bucket(Bucket="bucket")
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value
        yield settings
    finally:
        server.stop()
