# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports what could not be exported, so that nothing is lost silently."""


class Report:
    """Notes about things of the scene, each reported once, in the order in which they arose."""

    def __init__(self):
        self._notes = {}
        self.hint = ""

    def note(self, subject, message, hint=""):
        """Notes that `subject` (such as `material "Gold"`) is exported differently or not at all.
        `hint` gives in two words the reason why the picture may be unusable."""
        self._notes.setdefault((subject, message))
        self.hint = self.hint or hint

    def lines(self):
        """Returns one line for each message: the subjects that it concerns, then the message."""
        subjects_of = {}
        for subject, message in self._notes:
            subjects_of.setdefault(message, []).append(subject)
        return [f"{_list(subjects)}: {message}" for message, subjects in subjects_of.items()]

    def __len__(self):
        return len(self._notes)


def _list(subjects, most=6):
    shown = ", ".join(subjects[:most])
    return shown if len(subjects) <= most else f"{shown} and {len(subjects) - most} more"
