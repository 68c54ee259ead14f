'use strict';
// The grammars, with the engine that VS Code has for them.

const assert = require('node:assert/strict');
const { readFileSync, readdirSync, statSync } = require('node:fs');
const path = require('node:path');
const test = require('node:test');
const oniguruma = require('vscode-oniguruma');
const textmate = require('vscode-textmate');

const here = path.join(__dirname, '..');
const files = { 'source.prism': 'prism', 'source.prism.properties': 'prism-properties' };

const registry = (async () => {
  const wasm = readFileSync(require.resolve('vscode-oniguruma/release/onig.wasm'));
  await oniguruma.loadWASM(wasm.buffer.slice(wasm.byteOffset, wasm.byteOffset + wasm.byteLength));
  return new textmate.Registry({
    onigLib: Promise.resolve({
      createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
      createOnigString: (text) => new oniguruma.OnigString(text),
    }),
    loadGrammar: async (scope) => {
      const file = path.join(here, 'syntaxes', `${files[scope]}.tmLanguage.json`);
      return textmate.parseRawGrammar(readFileSync(file, 'utf8'), file);
    },
  });
})();

/** What each word of a text is taken for: the last of its scopes. */
async function scopes(scope, text) {
  const grammar = await (await registry).loadGrammar(scope);
  let stack = textmate.INITIAL;
  const found = [];
  for (const line of text.split('\n')) {
    const read = grammar.tokenizeLine(line, stack);
    stack = read.ruleStack;
    for (const token of read.tokens) {
      const word = line.slice(token.startIndex, token.endIndex);
      if (word.trim()) found.push([word.trim(), token.scopes.at(-1).replace(/\.prism$/, '')]);
    }
  }
  return found;
}

const has = (found, word, scope) => assert.ok(
  found.some(([a, b]) => a === word && b === scope),
  `${word} should be ${scope}: ${JSON.stringify(found.filter(([a]) => a === word))}`,
);

test('a model', async () => {
  const found = await scopes('source.prism', `mdp // a model
const double p = 1e-3;
formula busy = x>0 & mod(x,2)=1;
module robot
  x : [0..3] init 0;
  [go] x<3 -> p:(x'=x+1) + (1-p):true;
  [] busy -> true;
endmodule
module other = robot [x=y, go=stop] endmodule
label "done" = x=3;
rewards "time"
  [go] true : 1;
endrewards`);
  for (const [word, scope] of [
    ['mdp', 'keyword.other.model-type'], ['// a model', 'comment.line.double-slash'], ['const', 'storage.modifier'],
    ['double', 'storage.type'], ['p', 'variable.other.constant'], ['1e-3', 'constant.numeric'], ['busy', 'entity.name.function'],
    ['mod', 'support.function'], ['robot', 'entity.name.type.module'], ['x', 'variable.other.definition'], ['go', 'entity.name.label.action'],
    ['x', 'variable.other.readwrite'], ["'", 'keyword.operator.prime'], ['->', 'keyword.operator.arrow'], ['true', 'constant.language'],
    ['endmodule', 'keyword.control'], ['robot', 'entity.other.inherited-class'], ['"done"', 'entity.name.tag'], ['"time"', 'entity.name.section'],
    ['endrewards', 'keyword.control'], ['..', 'keyword.operator'],
  ]) has(found, word, scope);
});

test('properties', async () => {
  const found = await scopes('source.prism.properties', `const int k;
"fast": P>=0.9 [ F<=k "done" ]; // soon
R{"time"}min=? [ C<=k ]; Pmax=? [ x=1 U "done" ]; filter(min, P=? [ G a ], "init")`);
  for (const [word, scope] of [
    ['k', 'variable.other.constant'], ['"fast"', 'entity.name.function.property'], ['P', 'keyword.other.quantifier'],
    ['F', 'keyword.operator.temporal'], ['"done"', 'string.quoted.double'], ['// soon', 'comment.line.double-slash'],
    ['R', 'keyword.other.quantifier'], ['"time"', 'entity.name.section'], ['min', 'keyword.other.quantifier'], ['C', 'keyword.operator.temporal'],
    ['Pmax', 'keyword.other.quantifier'], ['U', 'keyword.operator.temporal'], ['filter', 'keyword.other.quantifier'], ['a', 'variable.other'],
  ]) has(found, word, scope);
});

/** The files of the project below a folder. */
function below(folder) {
  return readdirSync(folder).flatMap((name) => {
    const file = path.join(folder, name);
    return statSync(file).isDirectory() ? below(file) : [file];
  });
}

test('no word of the models at hand is left without a scope', async () => {
  const root = process.env.CORROBORATE_ROOT || path.join(here, '..', '..');
  const models = below(path.join(root, 'conformance', 'models')).filter((it) => it.endsWith('.prism'));
  assert.ok(models.length > 20);
  for (const file of models) {
    const found = await scopes('source.prism', readFileSync(file, 'utf8'));
    const bare = found.filter(([word, scope]) => scope === 'source' && /\w/.test(word));
    assert.deepEqual(bare, [], file);
  }
});

test('what the extension contributes is there', () => {
  const contributed = JSON.parse(readFileSync(path.join(here, 'package.json'), 'utf8')).contributes;
  for (const it of contributed.grammars) assert.equal(JSON.parse(readFileSync(path.join(here, it.path), 'utf8')).scopeName, it.scopeName);
  for (const it of contributed.languages) {
    const rules = JSON.parse(readFileSync(path.join(here, it.configuration), 'utf8'));
    for (const rule of Object.values(rules.indentationRules)) assert.ok(new RegExp(rule));
  }
});
