"""A local Dask cluster lets nobody else in, and one with TLS is used with its certificates."""

import os
import socket
import ssl
import sys
from pathlib import Path

import pytest

from tests.processes import children_of, until
from tests.twistcore.batch_folders import ROOT, clips
from twistcore.batch.clip_task import ClipTask
from twistcore.batch.dask_cluster import open_dask_cluster
from twistcore.batch.parameters import Parameters
from twistcore.cli.command_line import main

pytest.importorskip("distributed")
DIRTY = ROOT / "assets" / "walk_injected.bvh"
LISTENING = "0A"


def open_ports(pids):
    """The ports at which some processes listen (Linux)."""
    own = set()
    for pid in pids:
        links = [one for one in Path(f"/proc/{pid}/fd").iterdir() if one.is_symlink()]
        own |= {str(one.readlink()) for one in links}
    rows = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    rows = [row for row in rows if row[3] == LISTENING and f"socket:[{row[9]}]" in own]
    return {int(row[1].partition(":")[2], 16) for row in rows}


def answer(port, words):
    with socket.create_connection(("127.0.0.1", port), 5.0) as there:
        there.settimeout(5.0)
        there.sendall(words)
        try:
            return there.recv(100)
        except OSError:
            return b""


def speaks_tls(port):
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    try:
        with (
            socket.create_connection(("127.0.0.1", port), 5.0) as plain,
            context.wrap_socket(plain) as there,
        ):
            there.settimeout(5.0)
            return not there.recv(100)  # a certificate of its own is missing
    except ssl.SSLError as error:
        return "CERTIFICATE_REQUIRED" in str(error)


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_local_cluster_has_no_open_door(tmp_path):
    from distributed import Client
    from distributed.security import Security

    [clip] = clips(tmp_path / "in", DIRTY, 1, frames=150)
    with open_dask_cluster(None, 1) as carry_out:
        address = carry_out.args[0].scheduler.address
        assert address.startswith("tls://127.0.0.1:")
        task = ClipTask(str(clip), clip.name, clip.stat().st_size, Parameters())
        [(_, outcome)] = carry_out([task], lambda _task: 60.0)
        assert outcome.result is not None, outcome
        here = [os.getpid(), *children_of(os.getpid())]
        ports = until(lambda: open_ports(here))
        assert 8787 not in ports
        assert {
            port for port in ports if b"HTTP" in answer(port, b"GET / HTTP/1.0\r\n\r\n")
        } == set()
        assert all(map(speaks_tls, ports))
        for wrong in (Security.temporary(), Security()):
            with pytest.raises((OSError, TypeError)):
                Client(address, security=wrong, timeout=2.0, set_as_default=False)
        with pytest.raises((OSError, TypeError)):
            Client(address.replace("tls", "tcp"), timeout=2.0, set_as_default=False)


@pytest.mark.parametrize("address", ["tls://127.0.0.1:9", "tls://", "nothing://x", "127.0.0.1:9"])
def test_a_scheduler_that_cannot_be_reached_is_one_sentence(address, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("twistcore.batch.dask_cluster._CONNECT_S", 1.0)
    [clip] = clips(tmp_path / "in", DIRTY, 1, frames=150)
    words = ["batch", str(clip), "-o", str(tmp_path / "out"), "--scheduler", address]
    assert main(words) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert address in err
