# SPDX-License-Identifier: Apache-2.0
# Completion for bash: subcommands and options as `covis … --help` lists them, files elsewhere.
_covis() {
  local word=${COMP_WORDS[COMP_CWORD]} help subcommands i
  local -a command=("${COMP_WORDS[0]}")
  help=$("${command[@]}" --help 2> /dev/null)
  for ((i = 1; i < COMP_CWORD; ++i)); do
    subcommands=$(sed -n '/^Subcommands:/,/^$/s/^  \([a-z]\{1,\}\) .*/\1/p' <<< "$help")
    grep -qx -- "${COMP_WORDS[i]}" <<< "$subcommands" || break
    command+=("${COMP_WORDS[i]}")
    help=$("${command[@]}" --help 2> /dev/null)
  done
  if [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W "$(grep -oE -- '--[a-z][a-z0-9-]*' <<< "$help" | sort -u)" -- "$word"))
  elif ((i == COMP_CWORD)); then
    COMPREPLY=($(compgen -W "$(sed -n '/^Subcommands:/,/^$/s/^  \([a-z]\{1,\}\) .*/\1/p' <<< "$help")" -- "$word"))
  fi
}
complete -o default -F _covis covis
