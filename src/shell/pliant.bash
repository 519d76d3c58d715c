# Completion of pliant for bash, as `pliant completion` prints it.
_pliant() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} path='' options words files i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    [[ ${COMP_WORDS[i]} != -- ]] || return  # PETSc's options
    case "$path ${COMP_WORDS[i]}" in
      ' run') path='run' ;;
      ' resume') path='resume' ;;
      ' info') path='info' ;;
      ' report') path='report' ;;
      ' render') path='render' ;;
      ' plot') path='plot' ;;
      ' check') path='check' ;;
      ' converge') path='converge' ;;
      ' modes') path='modes' ;;
      ' sweep') path='sweep' ;;
      ' compare') path='compare' ;;
      ' sensitivity') path='sensitivity' ;;
      ' fit') path='fit' ;;
      ' mesh') path='mesh' ;;
      'mesh convert') path='mesh convert' ;;
      ' convert') path='convert' ;;
      ' methods') path='methods' ;;
      ' materials') path='materials' ;;
      'materials plot') path='materials plot' ;;
      ' schema') path='schema' ;;
      ' help') path='help' ;;
      ' completion') path='completion' ;;
      ' man') path='man' ;;
    esac
  done
  case $path in
    '') options='-h --help --version' words='run resume info report render plot check converge modes sweep compare sensitivity fit mesh convert methods materials schema help completion man' files='' ;;
    'run') options='-h --help --set -o --output --continue --quiet' words='' files='*.@(yaml|yml)' ;;
    'resume') options='-h --help --set -o --output --quiet' words='' files='*.h5' ;;
    'info') options='-h --help' words='' files='*.h5' ;;
    'report') options='-h --help -o --output --size --watch' words='' files='*.@(h5|xdmf)' ;;
    'render') options='-h --help -o --output --field --range --colour-map --movie --fps --frame --view --size --scale --cut --mirror --hide --transparent --title --frames --mesh-edges --outline --no-axes' words='' files='*.@(h5|xdmf)' ;;
    'plot') options='-h --help -o --output --of --x' words='' files='*' ;;
    'check') options='-h --help --set --html' words='' files='*.@(yaml|yml)' ;;
    'converge') options='-h --help --set -o --output --in --levels --methods --result --no-check' words='' files='*.@(yaml|yml)' ;;
    'modes') options='-h --help --set -o --output --number --near --unloaded' words='' files='*.@(yaml|yml)' ;;
    'sweep') options='-h --help --set -o --output --result --samples --seed --logarithmic --together --continue --jobs --ranks' words='' files='*.@(yaml|yml)' ;;
    'compare') options='-h --help --of -o --output' words='' files='*' ;;
    'sensitivity') options='-h --help --set -o --output --of --adjoint --to --fields --kept-steps' words='' files='*.@(yaml|yml)' ;;
    'fit') options='-h --help -o --output' words='' files='*.@(yaml|yml)' ;;
    'mesh') options='-h --help' words='convert' files='' ;;
    'mesh convert') options='-h --help --size --scale --allow-commands' words='' files='*' ;;
    'convert') options='-h --help -o --output --units --force' words='' files='*.@(inp|feb)' ;;
    'methods') options='-h --help' words='' files='' ;;
    'materials') options='-h --help --library --markdown' words='plot' files='' ;;
    'materials plot') options='-h --help --set --stretch -o --output' words='' files='*' ;;
    'schema') options='-h --help --fit --markdown' words='' files='' ;;
    'help') options='-h --help' words='' files='*' ;;
    'completion') options='-h --help' words='' files='' ;;
    'man') options='-h --help' words='' files='' ;;
  esac
  # What follows an option that takes a value is that.
  case $previous in
    --set | -o | --output | --size | --watch | --field | --range | --colour-map | --movie | --fps | --frame | --view | --scale | --cut | --mirror | --hide | --transparent | --title | --of | --x | --html | --in | --levels | --methods | --result | --number | --near | --samples | --seed | --logarithmic | --together | --jobs | --ranks | --adjoint | --to | --fields | --kept-steps | --units | --stretch) options='' words='' files='' ;;
  esac
  case "$path $previous" in
    'run -o' | 'run --output') files='*' ;;
    'resume -o' | 'resume --output') files='*' ;;
    'report -o' | 'report --output') files='*' ;;
    'render -o' | 'render --output') files='*' ;;
    'render --colour-map') words='auto viridis cividis inferno greys diverging' ;;
    'render --movie') words='mp4 gif glb' ;;
    'render --view') words='iso front back right left top bottom' ;;
    'plot -o' | 'plot --output') files='*' ;;
    'converge -o' | 'converge --output') files='*' ;;
    'converge --in') words='time space tolerance' ;;
    'modes -o' | 'modes --output') files='*' ;;
    'sweep -o' | 'sweep --output') files='*' ;;
    'compare -o' | 'compare --output') files='*' ;;
    'sensitivity -o' | 'sensitivity --output') files='*' ;;
    'fit -o' | 'fit --output') files='*' ;;
    'convert -o' | 'convert --output') files='*' ;;
    'convert --units') words='SI mm-N-s mm-kg-s mm-g-s mm-mg-s mm-kg-ms um-nN-s CGS' ;;
    'materials plot -o' | 'materials plot --output') files='*' ;;
  esac
  if [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$current")
  elif [[ $words ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  elif [[ $files ]]; then
    mapfile -t COMPREPLY < <({ shopt -s extglob; compgen -f -X "!$files" -- "$current"; compgen -d -- "$current"; } | sort -u)
    compopt -o filenames 2>/dev/null
  fi
}
complete -F _pliant pliant
