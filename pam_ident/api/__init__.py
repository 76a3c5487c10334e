"""The Python one would guess: `import pam_ident as pam` offers what is in here, and nothing else.

Names or objects anywhere. A verb reads, settles the law, asks one task and wraps its answer in a result that tells,
draws and saves itself; the nouns below stay as they are, under each result's `details`.
"""
