"""The same program as the installed `pam-ident` command, from the checkout."""

from pam_ident.cli import main

if __name__ == "__main__":
    main()
