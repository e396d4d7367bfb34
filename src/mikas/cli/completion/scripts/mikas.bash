# Completion of mikas in bash 4.4 or newer. In ~/.bashrc: eval "$(mikas completion bash)"

_mikas_complete() {
    local IFS=$'\n' kind value note before= here=$2 file ending found
    COMPREPLY=()
    while IFS=$'\t' read -r kind value note; do
        case $kind in
        word) # readline keeps what stands before the last : or = of a word
            [[ $value == *"$here" ]] && before=${value%"$here"}
            ;;
        plain)
            value=${value#"$before"}
            [[ $value == *[\ \"\'\?\*\&\;\(\)\<\>\|\$]* ]] && printf -v value %q "$value"
            COMPREPLY+=("$value")
            ;;
        open) # something follows without a blank
            compopt -o nospace
            value=${value#"$before"}
            COMPREPLY+=("${value//\?/\\?}")
            ;;
        file | dir)
            compopt -o filenames
            note=${note#"$before"}
            COMPREPLY+=($(compgen -P "$note" -d -- "${here#"$note"}"))
            [[ $kind == dir ]] && continue
            found=
            for file in $(compgen -f -- "${here#"$note"}"); do
                [[ -d ${file/#\~\//$HOME/} ]] && continue
                for ending in ${value//,/$IFS}; do
                    [[ $file == *".$ending" ]] && COMPREPLY+=("$note$file") found=1
                done
            done
            [[ $found ]] && continue
            for file in $(compgen -f -- "${here#"$note"}"); do
                [[ -d ${file/#\~\//$HOME/} ]] || COMPREPLY+=("$note$file")
            done
            ;;
        esac
    done < <(
        COMP_LINE=${COMP_LINE:0:COMP_POINT} _MIKAS_COMPLETE=bash_complete \
            "${1/#\~\//$HOME/}" 2>/dev/null
    )
}

complete -o nosort -F _mikas_complete mikas
