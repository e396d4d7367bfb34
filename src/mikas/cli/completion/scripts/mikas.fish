# Completion of mikas in fish. In ~/.config/fish/config.fish: mikas completion fish | source

function __mikas_complete
    set -l words (commandline -opc)
    set -l word (commandline -ct) # as it is written, maybe with an open quote
    set -lx _MIKAS_COMPLETE fish_complete
    set -lx COMP_WORDS (begin
        printf '%s\n' $words
        printf %s $word
    end | string collect -N)
    for line in (command $words[1] 2>/dev/null)
        set -l parts (string split \t -- $line)
        switch $parts[1]
            case plain open
                printf '%s\t%s\n' $parts[2] $parts[3]
            case file dir
                set -l begin $parts[3]
                set -l rest $word
                test -n "$begin"; and set rest (string replace -- $begin '' $word)
                set -l found (__fish_complete_path $rest | string replace -r '\t.*' '')
                set -l files (string match -v -- '*/' $found)
                if test $parts[1] = dir
                    set files
                else if test -n "$parts[2]"
                    set -l endings (string replace -a , '|' -- $parts[2])
                    set -l fitting (string match -r -i -- '^.*\.(?:'$endings')$' $files)
                    test (count $fitting) -gt 0; and set files $fitting
                end
                for file in (string match -- '*/' $found) $files
                    printf '%s\n' $begin$file
                end
        end
    end
end

complete --command mikas --no-files --keep-order --arguments '(__mikas_complete)'
