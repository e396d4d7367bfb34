# Completion of mikas in PowerShell 5.1 or newer. In $PROFILE:
# mikas completion powershell | Out-String | Invoke-Expression

Register-ArgumentCompleter -Native -CommandName 'mikas', 'mikas.exe' -ScriptBlock {
    param($wordToComplete, $commandAst, $cursorPosition)

    # The words left of the cursor, without their quotes. PowerShell completes what is behind the
    # last comma of a word; mikas is asked for the whole word.
    $words = @()
    $word = ''
    foreach ($element in $commandAst.CommandElements) {
        $extent = $element.Extent
        if ($extent.EndOffset -lt $cursorPosition) {
            $isText = $element -is [System.Management.Automation.Language.StringConstantExpressionAst]
            $words += if ($isText) { $element.Value } else { $extent.Text }
        } elseif ($extent.StartOffset -lt $cursorPosition) {
            $word = $extent.Text.Substring(0, $cursorPosition - $extent.StartOffset).Trim('"', "'")
        }
    }
    $here = "$wordToComplete".Trim('"', "'")
    $kept = if ($word.EndsWith($here)) { $word.Substring(0, $word.Length - $here.Length) } else { '' }

    $asked = @{
        _MIKAS_COMPLETE = 'powershell_complete'
        COMP_WORDS = ($words + $word) -join "`n"
    }
    $former = @{}
    $encoding = [Console]::OutputEncoding
    $answer = @()
    try {
        foreach ($name in $asked.Keys) {
            $former[$name] = [Environment]::GetEnvironmentVariable($name)
            [Environment]::SetEnvironmentVariable($name, $asked[$name])
        }
        [Console]::OutputEncoding = [System.Text.UTF8Encoding]::new($false)
        $answer = @(& $words[0] 2>$null)
    } catch {
        # In the middle of a line a message would be in the way.
    } finally {
        [Console]::OutputEncoding = $encoding
        foreach ($name in $asked.Keys) {
            [Environment]::SetEnvironmentVariable($name, $former[$name])
        }
    }

    foreach ($line in $answer) {
        $kind, $value, $note = "$line" -split "`t"
        if ($kind -eq 'plain' -or $kind -eq 'open') {
            $tip = if ($note) { $note } else { $value }
            if ($kept -and $value.StartsWith($kept)) { $value = $value.Substring($kept.Length) }
            $written = $value
            if ($value -match '[\s&;|<>(){}$`''"@#,]') {
                $written = "'" + $value.Replace("'", "''") + "'"
            }
            [System.Management.Automation.CompletionResult]::new(
                $written, $value, 'ParameterValue', $tip)
        } elseif ($kind -eq 'file' -or $kind -eq 'dir') {
            $begin = if ($note -and $here.StartsWith($note)) { $note } else { '' }
            $rest = $here.Substring($begin.Length)
            $found = @([System.Management.Automation.CompletionCompleters]::CompleteFilename($rest))
            $dirs = @($found | Where-Object { $_.ResultType -eq 'ProviderContainer' })
            $files = @()
            if ($kind -eq 'file') {
                $files = @($found | Where-Object { $_.ResultType -ne 'ProviderContainer' })
                $endings = $value -split ','
                $fitting = @($files |
                    Where-Object { $endings -contains ($_.ListItemText -split '\.')[-1] })
                if ($fitting.Count) { $files = $fitting }
            }
            foreach ($it in $dirs + $files) {
                [System.Management.Automation.CompletionResult]::new(
                    "$begin$($it.CompletionText)", $it.ListItemText, $it.ResultType, $it.ToolTip)
            }
        }
    }
}
