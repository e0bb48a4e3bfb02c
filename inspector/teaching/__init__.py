"""The teaching tab: the paper's section 3 at the selected joint, a tour, an exercise, recording."""

from inspector.teaching.lesson import Lesson
from inspector.teaching.panel import TeachingPanel

__all__ = ["Lesson", "TeachingPanel"]
