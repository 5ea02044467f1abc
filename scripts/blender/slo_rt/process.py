# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs slo-rt and watches it. Knows nothing of Blender."""

import json
import os
import queue
import re
import signal
import subprocess
import threading
import time
from dataclasses import dataclass, field

POLL_SECONDS = 0.1
GRACE_SECONDS = 5.0  # after being asked to stop, before it is made to
STOPPED_CODES = {75, 130}
_PERCENT = re.compile(r"slo-rt:\s+(\d+)\s*%")


@dataclass
class Outcome:
    """How a run ended: exit code, whether it was asked to stop, and what it said on standard
    error."""

    code: int
    stopped: bool
    messages: list = field(default_factory=list)

    @property
    def succeeded(self):
        """Whether the picture is complete."""
        return self.code == 0

    def complaint(self):
        """What went wrong, in the program's words."""
        text = "\n".join(self.messages).strip()
        return "\n".join(part for part in (text, self._end()) if part)

    def _end(self):
        """How a program ended that did not say why."""
        if self.code < 0:
            return f"slo-rt was ended by {_signal_name(-self.code)}"
        return "" if self.messages else f"slo-rt ended with exit code {self.code}"


def _signal_name(number):
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def run(command, on_progress, should_stop):
    """Runs a command to its end.

    `on_progress(fraction)` is called whenever the program tells how far it is; `should_stop()`
    several times a second, and when it is true the program is asked to stop as Ctrl-C does, so that
    it can save what it has.

    # Errors
    `OSError` where the program can't be started.
    """
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "NO_COLOR": "1"},
        **_able_to_stop(),
    )
    lines = queue.SimpleQueue()
    readers = [
        threading.Thread(target=_read, args=(stream, is_talk, lines), daemon=True)
        for stream, is_talk in ((process.stdout, False), (process.stderr, True))
    ]
    for reader in readers:
        reader.start()
    messages = []
    stopped = False
    try:
        while process.poll() is None or any(reader.is_alive() for reader in readers):
            _drain(lines, messages, on_progress, POLL_SECONDS)
            if not stopped and process.poll() is None and should_stop():
                stopped = True
                _stop(process)
        _drain(lines, messages, on_progress, 0.0)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
    return Outcome(process.returncode, stopped, messages)


def fraction_of(line):
    """How far a frame is (0 to 1) by a line of the program, or None if it says nothing of it.

    Understands the events of `--progress json` and the lines for people.
    """
    event = event_of(line)
    if event is not None:
        fraction = event.get("fraction")
        return min(max(float(fraction), 0.0), 1.0) if isinstance(fraction, (int, float)) else None
    percent = _PERCENT.match(line)
    return int(percent.group(1)) / 100.0 if percent else None


def event_of(line):
    """The JSON object on a line, or None."""
    if not line.startswith("{"):
        return None
    try:
        event = json.loads(line)
    except ValueError:
        return None
    return event if isinstance(event, dict) else None


def _read(stream, is_talk, lines):
    with stream:
        for line in stream:
            lines.put((is_talk, line.decode("utf-8", "replace").rstrip("\r\n")))


def _drain(lines, messages, on_progress, wait):
    """Takes what has come; waits up to `wait` seconds for the first line."""
    try:
        is_talk, line = lines.get(timeout=wait) if wait else lines.get_nowait()
        while True:
            fraction = fraction_of(line)
            if fraction is not None:
                on_progress(fraction)
            elif event_of(line) is not None:
                failure = event_of(line).get("message")
                messages += [failure] if failure and failure not in "\n".join(messages) else []
            elif is_talk:
                messages.append(line)
            is_talk, line = lines.get_nowait()
    except queue.Empty:
        pass


def _stop(process):
    """Asks the program to stop, and makes it stop if it doesn't."""
    process.send_signal(signal.CTRL_BREAK_EVENT if os.name == "nt" else signal.SIGINT)
    deadline = time.monotonic() + GRACE_SECONDS
    while process.poll() is None and time.monotonic() < deadline:
        time.sleep(POLL_SECONDS / 4.0)
    if process.poll() is None:
        process.kill()


def _able_to_stop():
    """Options for a program that can be asked to stop: on Windows only in a group of its own,
    elsewhere only if it does not inherit that Ctrl-C is ignored, as jobs in the background do."""
    if os.name == "nt":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        return {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)}
    return {}
