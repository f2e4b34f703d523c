"""`completion bash|zsh|fish`: what makes a shell complete commands and options, made from the parsers of the commands."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from daemon.cli.commands import COMMANDS, CommandParser

_EPILOG = """\
bash: eval "$(longreach completion bash)" in ~/.bashrc; zsh: the same with zsh, after compinit, in ~/.zshrc;
fish: longreach completion fish > ~/.config/fish/completions/longreach.fish
"""


def options(parser: argparse.ArgumentParser) -> None:
    parser.epilog = _EPILOG
    parser.add_argument("shell", choices=("bash", "zsh", "fish"))
    parser.set_defaults(run_command=_completion)


def _completion(arguments: argparse.Namespace) -> int:
    words = {command.name: list(_words(command.options)) for command in COMMANDS}
    print(_fish(words) if arguments.shell == "fish" else _bash(words, zsh=arguments.shell == "zsh"))
    return 0


def _words(options_of: str) -> Iterator[str]:
    """Long options, fixed words and verbs of a command, with the options of its verbs."""
    parser = CommandParser(options=options_of)
    parser.load()
    parsers: list[argparse.ArgumentParser] = [parser]
    seen: set[str] = set()
    for each in parsers:
        for action in each._actions:
            if isinstance(action, argparse._SubParsersAction):
                parsers += action.choices.values()
            fixed = map(str, action.choices or ()) if not action.option_strings else ()
            for word in (*(option for option in action.option_strings if option.startswith("--")), *fixed):
                if word not in seen:
                    seen.add(word)
                    yield word


def _bash(words: dict[str, list[str]], zsh: bool) -> str:
    cases = "\n".join(f"    {name}) words='{' '.join(of)}' ;;" for name, of in words.items())
    begin = "autoload -U +X bashcompinit && bashcompinit\n" if zsh else ""
    return f"""{begin}_longreach() {{
  local current="${{COMP_WORDS[COMP_CWORD]}}" words
  case "${{COMP_WORDS[1]}}" in
{cases}
  esac
  [ "$COMP_CWORD" -eq 1 ] && words='{" ".join(words)}'
  COMPREPLY=($(compgen -W "$words" -- "$current"))
}}
complete -o default -F _longreach longreach"""


def _fish(words: dict[str, list[str]]) -> str:
    helps = {command.name: command.help.replace("'", "") for command in COMMANDS}
    lines = [f"complete -c longreach -n __fish_use_subcommand -a {name} -d '{helps[name]}'" for name in words]
    for name, of in words.items():
        lines.append(f"complete -c longreach -n '__fish_seen_subcommand_from {name}' -a '{' '.join(of)}'")
    return "\n".join(lines)
