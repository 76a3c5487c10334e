"""Whole tasks, one a file, for the command line and notebooks alike: results out, nothing printed.

Import a task from its own file, such as `from pam_ident.workflow.fit_record import fit_record`, so that a fit does
not load what only a report needs.
"""
