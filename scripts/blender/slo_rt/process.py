# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs slo-rt and watches it. Independent of Blender."""

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
GRACE_SECONDS = 5.0  # between asking the program to stop and killing it
STOPPED_CODES = {75, 130}
_PERCENT = re.compile(r"slo-rt:\s+(\d+)\s*%")


@dataclass
class Outcome:
    """Result of a run: exit code, whether it was asked to stop, and its output on standard error."""

    code: int
    stopped: bool
    messages: list = field(default_factory=list)

    @property
    def succeeded(self):
        """Whether the picture is complete."""
        return self.code == 0

    def complaint(self):
        """Returns the program's error message."""
        text = "\n".join(self.messages).strip()
        return "\n".join(part for part in (text, self._end()) if part)

    def _end(self):
        """Returns how a program ended that printed no message."""
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

    `on_progress(fraction)` is called whenever the program reports progress. `should_stop()` is called
    several times a second; if it returns true, the program is asked to stop as by Ctrl-C, so that it
    can save its samples.

    # Errors
    `OSError` if the program cannot be started.
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
    """Returns the progress of a frame (0 to 1) from a line of the program, or None if it has none.

    Understands the events of `--progress json` and the lines for people.
    """
    event = event_of(line)
    if event is not None:
        fraction = event.get("fraction")
        return min(max(float(fraction), 0.0), 1.0) if isinstance(fraction, (int, float)) else None
    percent = _PERCENT.match(line)
    return int(percent.group(1)) / 100.0 if percent else None


def event_of(line):
    """Returns the JSON object on a line, or None."""
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
    """Takes the lines that have arrived; waits up to `wait` seconds for the first one."""
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
    """Returns options for a program that can be asked to stop: on Windows it must have a group of its
    own; elsewhere it must not inherit that Ctrl-C is ignored, as background jobs do."""
    if os.name == "nt":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        return {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)}
    return {}
