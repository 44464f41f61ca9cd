"""Module that misbehaves when it is imported."""

import os

os._exit(0)
