"""Two reviewers: another review of the open clip, compared with this one."""
