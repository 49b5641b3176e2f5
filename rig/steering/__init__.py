"""Change the gains of a run that goes on: a mailbox that its loop looks into once a cycle."""
