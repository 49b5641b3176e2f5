"""What the program's words mean: keys of files, measures, commands, exit codes, and faults."""

from rig.explaining.faults import FaultTopic, fault_topics, topic_of
from rig.explaining.glossary import Word, exit_codes, glossary

__all__ = ["FaultTopic", "Word", "exit_codes", "fault_topics", "glossary", "topic_of"]
