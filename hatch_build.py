"""Build hook of the package: compiles the kernel in C where there is a compiler."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ADVICE = "barchain: no compiled kernel, NumPy serves alone; `barchain doctor` tells what is missing and how to get it"


class KernelHook(BuildHookInterface[Any]):
    """Compiles `reference_impl/kernel/c` into `reference_impl/kernel/built`, which the wheel carries."""

    @property
    def build(self) -> Any:
        """Module of the compilation, loaded by its path: the package is not installed yet."""
        path = Path(self.root) / "reference_impl" / "kernel" / "build.py"
        spec = importlib.util.spec_from_file_location("kernel_build", path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    def dependencies(self) -> list[str]:
        """Distribution of a compiler, only where the machine has none."""
        build = self.build
        return [] if os.environ.get(build.NO_KERNEL) or build.compiler() else ["ziglang"]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile; without a compiler, or if it fails, install without the kernel and say so."""
        build = self.build
        command = None if os.environ.get(build.NO_KERNEL) else build.compiler()
        if self.target_name != "wheel":
            return
        if command is None:
            self.app.display_warning(ADVICE)
            return
        wanted = build.wanted_levels()
        try:
            build.build(command, wanted=wanted)
        except (OSError, subprocess.CalledProcessError) as error:
            if os.environ.get(build.EXTRA_FLAGS):  # asked for by somebody who wants to know
                raise RuntimeError(getattr(error, "stderr", "") or str(error)) from error
            self.app.display_warning(f"{getattr(error, 'stderr', '') or error}\n{ADVICE}")
            return
        build_data["artifacts"].append("reference_impl/kernel/built/kernel-*")
        if version != "editable":
            platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data["pure_python"], build_data["tag"] = False, f"py3-none-{platform}"
