"""The page about touching a twin does what it says."""

import os
import re
import socket
import subprocess
import sys
from pathlib import Path

from canopen_twins.live.hub_process import hub_process

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "touch-a-running-twin.md"
BEGIN = "trap 'kill $(jobs -p) 2>/dev/null || true' EXIT\n"
READY = "until grep -qs ready {}; do sleep 0.1; done\n"


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return str(server.getsockname()[1])


def in_the_background(line, out):
    """A line of shell that ends in `&`, and then its ready line waited for."""
    return f"{line.rstrip().removesuffix('&')} > {out} &\n{READY.format(out)}"


def test_the_page_does_what_it_says(tmp_path):
    text = PAGE.read_text("utf-8")
    _, start, *blocks = re.findall(r"```sh\n(.*?)```", text, re.DOTALL)
    (python,) = re.findall(r"```python file=touch.py\n(.*?)```", text, re.DOTALL)
    port = free_port()
    (tmp_path / "touch.py").write_text(python.replace("8123", port))
    lines = [BEGIN, in_the_background(start, "run.out"), *blocks, "python touch.py\n"]
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    with hub_process() as hub:  # not the usual one, which others may be on
        script = "".join(lines).replace("8123", port).replace("--hub", f"--hub {hub}")
        done = subprocess.run(
            ["bash", "-exc", script],
            cwd=tmp_path,
            env={**os.environ, "PATH": path, "XDG_RUNTIME_DIR": str(tmp_path)},
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
    assert done.returncode == 0, done.stdout + done.stderr
    assert '"running": true' in done.stdout
    assert "Active:\n\nheartbeat_late(seconds=0.5)\n" in done.stdout
    assert "OPERATIONAL {'Actual voltage': " in done.stdout
