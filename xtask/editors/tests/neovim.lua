-- Uses each feature of the language server in Neovim, and prints a table: the feature, the input and the result.
-- The current folder is a workspace. The exit status is 1 if a result isn't as expected.

local LIMIT = 60000
local rows, failures = {}, {}

local function row(feature, input, result, expected)
  result = type(result) == "string" and result or vim.fn.json_encode(result)
  table.insert(rows, { feature, input, result })
  if not result:find(expected) then
    table.insert(failures, feature .. ": expected " .. expected .. ", found " .. result)
  end
end

local function client_of(buffer)
  local clients = vim.lsp.get_clients or vim.lsp.buf_get_clients
  for _, client in pairs(vim.lsp.get_clients and clients({ bufnr = buffer }) or clients(buffer)) do
    return client
  end
end

-- Opens a file, waits for the server, and moves the cursor to the `|` in a part of the text.
local function open(name)
  vim.cmd("edit " .. name)
  assert(vim.wait(LIMIT, function()
    local client = client_of(0)
    return client and client.initialized
  end), "no server for " .. name)
end

local function place(marked)
  local column = marked:find("|", 1, true) - 1
  local part = marked:gsub("|", "", 1)
  for number, line in ipairs(vim.api.nvim_buf_get_lines(0, 0, -1, false)) do
    local start = line:find(part, 1, true)
    if start then
      return vim.api.nvim_win_set_cursor(0, { number, start - 1 + column })
    end
  end
  error("the buffer lacks " .. part)
end

local function ask(method, more)
  local encoding = client_of(0).offset_encoding
  local params = vim.lsp.util.make_position_params(0, encoding)
  params = vim.tbl_extend("force", params, more or {})
  local answers = assert(vim.lsp.buf_request_sync(0, method, params, LIMIT), "no answer to " .. method)
  for _, answer in pairs(answers) do
    return answer.result, answer.error or answer.err
  end
end

local function all()
  local last = vim.api.nvim_buf_line_count(0)
  return { start = { line = 0, character = 0 }, ["end"] = { line = last, character = 0 } }
end

local function type_line(old, new)
  place("|" .. old)
  local at = vim.api.nvim_win_get_cursor(0)
  vim.api.nvim_buf_set_text(0, at[1] - 1, at[2], at[1] - 1, at[2] + #old, { new })
end

local function diagnostics(count)
  assert(vim.wait(LIMIT, function() return #vim.diagnostic.get(0) == count end), "expected " .. count .. " findings")
  return vim.tbl_map(function(found) return found.message end, vim.diagnostic.get(0))
end

local function labels(items)
  return table.concat(vim.tbl_map(function(item) return item.label end, items), " ")
end

local function drive()
  open("msg/Glider.msg")
  row("server", "vim.lsp", client_of(0).name .. ", " .. client_of(0).offset_encoding, "uavspec, utf")

  type_line("Wind[2]", "Wnd[2]")
  row("diagnostics", "Wnd[2] typed", diagnostics(1), "no message `Wnd`")
  type_line("Wnd[2]", "Wind[2]")
  row("diagnostics", "Wind[2] typed", diagnostics(0), "%[%]")

  type_line("[@enum PHASE]", "[enum PHASE]")
  diagnostics(1)
  local fixes = ask("textDocument/codeAction", { range = all(), context = { diagnostics = {}, only = { "quickfix" } } })
  vim.lsp.util.apply_workspace_edit(fixes[1].edit, client_of(0).offset_encoding)
  row("quick fix", fixes[1].title, vim.fn.getline(7), "%[@enum PHASE%]")
  diagnostics(0)

  place("si|nk")
  row("hover", "sink", ask("textDocument/hover").contents.value, "offset 8, 4 of 48 bytes")
  place("Wi|nd[2]")
  row("definition", "Wind", ask("textDocument/definition"), "Wind.msg")
  place("PHASE_TO|W")
  row("references", "PHASE_TOW", ask("textDocument/references", { context = { includeDeclaration = true } }), "Tow.msg")
  row("highlights", "PHASE_TOW", #ask("textDocument/documentHighlight") .. " places", "2 places")
  row("document symbols", "Glider.msg", ask("textDocument/documentSymbol"), "PHASE_FREE")
  row("workspace symbols", "speed", ask("workspace/symbol", { query = "speed" }), "Wind.msg")
  row("folding", "Glider.msg", ask("textDocument/foldingRange"), "startLine")
  row("semantic tokens", "Glider.msg", #ask("textDocument/semanticTokens/full").data / 5 .. " tokens", "%d%d tokens")
  local hints = labels(ask("textDocument/inlayHint", { range = all() }))
  row("inlay hints", "Glider.msg", hints, "@0 @12, then 3 padding @8 @16")
  row("layout", "Glider.msg", ask("uavspec/layout")[1].svg:match("<title>(.-)</title>"), "48 bytes")
  place("[|m/s]")
  row("completion", "[", labels(ask("textDocument/completion")), "m/s")

  local edits = ask("textDocument/formatting", { options = { tabSize = 2, insertSpaces = true } })
  vim.lsp.util.apply_text_edits(edits, vim.api.nvim_get_current_buf(), client_of(0).offset_encoding)
  row("formatting", "Glider.msg", vim.fn.getline(6), "^uint8 PHASE_FREE = 1  # Released$")

  place("Wi|nd[2]")
  vim.cmd("silent write")
  local edit = ask("textDocument/rename", { newName = "Breeze" })
  vim.lsp.util.apply_workspace_edit(edit, client_of(0).offset_encoding)
  row("rename", "Wind to Breeze", vim.fn.getline(9) .. ", " .. vim.fn.glob("msg/*"), "^Breeze%[2%].*msg/Breeze.msg")

  open("msg/Tow.msg")
  place("uint8 ph|ase")
  local _, refusal = ask("textDocument/rename", { newName = "state" })
  row("refused rename", "phase to state", refusal.message, "raise MESSAGE_VERSION to 2")

  local client = client_of(0)
  vim.lsp.stop_client(client.id)
  row("shutdown", "vim.lsp.stop_client", tostring(vim.wait(LIMIT, function() return client.is_stopped() end)), "true")
end

local ok, problem = xpcall(drive, debug.traceback)
if not ok then
  table.insert(failures, problem)
end
local lines = {}
for _, cells in ipairs(rows) do
  local text = cells[3]:gsub("%s+", " ")
  text = #text > 160 and text:sub(1, 157) .. "..." or text
  table.insert(lines, ("%-18s | %-20s | %s"):format(cells[1], cells[2], text))
end
vim.list_extend(lines, failures)
io.stdout:write(table.concat(lines, "\n"), "\n")
vim.cmd(#failures == 0 and "qall!" or "cquit 1")
