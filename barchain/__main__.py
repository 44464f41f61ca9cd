"""`python -m barchain`: the command line without the script on the path."""

from barchain.cli.main import main

if __name__ == "__main__":  # worker processes import this module too
    main()
