"""`python -m barchain`: the command line without the script on the path."""

import sys

if __name__ == "__main__":  # worker processes import this module too
    if not sys.flags.safe_path:  # `-m` puts the current folder first, before all that barchain needs
        sys.path.append(sys.path.pop(0))
    from barchain.cli.main import main

    main()
