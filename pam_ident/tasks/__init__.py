"""What a user asks of one record, a task a file: the door for the command line, the workbench and notebooks alike.

A task takes what was asked as a `Setup`, gives results back and prints nothing. Import it from its own file, such as
`from pam_ident.tasks.fit import fit_record`, so that a fit does not load what only a report needs.
"""
