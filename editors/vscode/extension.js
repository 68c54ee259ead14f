'use strict';
// Starts `corroborate language-server` and lets VS Code's client speak to it. All else is in the program.

const vscode = require('vscode');
const { LanguageClient, TransportKind } = require('vscode-languageclient/node');

/** The scheme of the pages that say what a diagnostic's code means. */
const EXPLAIN = 'corroborate-explain';

/** The client, while it runs. */
let client;

/** The program that the settings name. */
function program() {
  const named = vscode.workspace.getConfiguration('corroborate').get('path');
  return (named || '').trim() || 'corroborate';
}

function serverOptions() {
  const command = { command: program(), args: ['language-server'], transport: TransportKind.stdio };
  return { run: command, debug: command };
}

function clientOptions(output) {
  const schemes = ['file', 'untitled'];
  const languages = ['prism', 'prism-properties'];
  const selector = languages.flatMap((language) => schemes.map((scheme) => ({ scheme, language })));
  // By their names: VS Code has no language of its own for TOML.
  selector.push({ scheme: 'file', pattern: '**/*.toml' });
  return {
    documentSelector: selector,
    outputChannel: output,
    initializationOptions: { explainScheme: EXPLAIN },
    // A program that cannot be started is told once, below, with what can be done.
    initializationFailedHandler: () => false,
    connectionOptions: { maxRestartCount: 3 },
  };
}

/** Says that the program cannot be started, and offers to name it. */
async function tellMissing(error, output) {
  const reason = error && error.message ? error.message : String(error);
  output.appendLine(`${program()}: ${reason}`);
  const settings = 'Open the setting';
  const message =
    `Corroborate: the program \`${program()}\` cannot be started (${reason}). ` +
    'Install it, or name it in the setting `corroborate.path`.';
  const chosen = await vscode.window.showErrorMessage(message, settings);
  if (chosen === settings) {
    await vscode.commands.executeCommand('workbench.action.openSettings', 'corroborate.path');
  }
}

async function start(output) {
  const started = new LanguageClient('corroborate', 'Corroborate', serverOptions(), clientOptions(output));
  client = started;
  try {
    await started.start();
  } catch (error) {
    client = undefined;
    // Not awaited: nobody has to answer a message for the editor to go on.
    void tellMissing(error, output);
  }
}

async function stop() {
  const running = client;
  client = undefined;
  // One that never ran, or has ended, has nothing to be stopped.
  if (running && running.needsStop()) await running.stop();
}

/** What a diagnostic's code means, as `corroborate explain` says it. */
async function explained(uri) {
  const code = uri.path.replace(/\.txt$/, '');
  if (!client) return `The program does not run, so \`${code}\` cannot be explained here.\n`;
  const text = await client.sendRequest('corroborate/explain', { code });
  return `${code}\n\n${text || 'Nothing is known of this code.'}\n`;
}

async function activate(context) {
  const output = vscode.window.createOutputChannel('Corroborate');
  const restart = async () => {
    await stop();
    await start(output);
  };
  context.subscriptions.push(
    output,
    vscode.commands.registerCommand('corroborate.restart', restart),
    vscode.workspace.registerTextDocumentContentProvider(EXPLAIN, { provideTextDocumentContent: explained }),
    vscode.workspace.onDidChangeConfiguration((change) =>
      change.affectsConfiguration('corroborate.path') ? restart() : undefined,
    ),
  );
  await start(output);
}

module.exports = { activate, deactivate: stop };
