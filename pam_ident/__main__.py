"""`python -m pam_ident` is the same program as `pam-ident`."""

from .cli import main

if __name__ == "__main__":
    main()
