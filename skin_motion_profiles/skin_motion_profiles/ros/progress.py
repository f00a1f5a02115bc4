"""A progress line: rewritten in place on a terminal, one line per profile elsewhere."""

import shutil
from typing import Any, TextIO

_BAR = 20  # characters


class ProgressLine:
    """Shows the feedback of an `execute_profile` goal."""

    def __init__(self, out: TextIO) -> None:
        """Write to `out`."""
        self.out, self.live, self.segment, self.open = out, out.isatty(), "", False

    def update(self, feedback: Any) -> None:
        """Show an `ExecuteProfile.Feedback`."""
        if self.live:
            width = shutil.get_terminal_size().columns - 1
            self.out.write("\r" + progress_text(feedback)[:width].ljust(width))
            self.open = True
        elif feedback.segment != self.segment:
            self.out.write(progress_text(feedback) + "\n")
        self.segment = feedback.segment
        self.out.flush()

    def close(self) -> None:
        """Leave the line."""
        if self.open:
            self.out.write("\n")
            self.out.flush()


def progress_text(feedback: Any) -> str:
    """For instance `[#####...............]  25 %    0.512 mm    6.21 N  peak   7.30 N  3/13 sine`."""
    bar = "#" * round(_BAR * feedback.progress)
    numbers = f"{feedback.depth * 1e3:8.3f} mm {feedback.force:7.2f} N  peak {feedback.peak_force:6.2f} N"
    return f"[{bar:.<{_BAR}}] {feedback.progress:4.0%} {numbers}  {feedback.segment}"
