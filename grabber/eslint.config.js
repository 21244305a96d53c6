// Rules for TypeScript, the grabber's and the web page's, and for its tests: npm run lint. Prettier
// decides about the layout (one statement a line, at most 100 columns), so no rule here does.
import { fileURLToPath } from 'node:url';
import js from '@eslint/js';
import { defineConfig } from 'eslint/config';
import tseslint from 'typescript-eslint';

const kRoot = fileURLToPath(new URL('..', import.meta.url));
const kProjects = [
  'grabber/tsconfig.test.json',
  'tests/page/tsconfig.json',
  'voxelserver/serve/page/tsconfig.json',
];

export default defineConfig(
  { ignores: ['**/dist/', '**/dist-test/', '**/node_modules/'] },
  js.configs.recommended,
  {
    files: ['**/*.js', '**/*.mjs'],
    languageOptions: { globals: { console: 'readonly', process: 'readonly', URL: 'readonly' } },
  },
  {
    files: ['**/*.ts'],
    extends: [tseslint.configs.recommendedTypeChecked],
    languageOptions: {
      parserOptions: { project: kProjects, tsconfigRootDir: kRoot },
    },
    rules: {
      // An async function also turns what it throws into a rejection, as its contract says.
      '@typescript-eslint/require-await': 'off',
      '@typescript-eslint/consistent-type-definitions': ['error', 'type'],
      '@typescript-eslint/consistent-type-imports': 'error',
      '@typescript-eslint/explicit-module-boundary-types': 'error',
      '@typescript-eslint/switch-exhaustiveness-check': 'error',
      // Messages contain numbers; everything else is turned into text deliberately.
      '@typescript-eslint/restrict-template-expressions': ['error', { allowNumber: true }],
      // The test runner awaits the tests; the file that declares them does not have to.
      '@typescript-eslint/no-floating-promises': [
        'error',
        {
          allowForKnownSafeCalls: [
            { from: 'package', name: ['describe', 'test'], package: 'node:test' },
          ],
        },
      ],
    },
  },
  {
    rules: {
      // A body on a line of its own has braces; a short one may stand behind its condition.
      curly: ['error', 'multi-line'],
      eqeqeq: 'error',
      'max-depth': ['error', 4],
      // Prettier breaks neither comments nor texts.
      'max-len': ['error', { code: 100 }],
      'max-lines-per-function': ['error', { max: 60, skipBlankLines: true, skipComments: true }],
      'no-multi-assign': 'error',
      'no-nested-ternary': 'error',
      'no-restricted-syntax': [
        'error',
        {
          selector: ':not(ExpressionStatement, ForStatement) > UpdateExpression',
          message: 'Count in a statement of its own.',
        },
      ],
      'no-sequences': ['error', { allowInParentheses: false }],
      'no-unneeded-ternary': 'error',
      'one-var': ['error', 'never'],
    },
  },
  {
    files: ['**/tests/page/**/*.ts'],
    // A story in a browser is one sequence, whose steps share a server and a page.
    rules: { 'max-lines-per-function': 'off', 'max-depth': ['error', 5] },
  },
  {
    files: ['**/page/src/viewer/ui/**/*.ts'],
    // A tool is the state of one panel and the functions around it.
    rules: { 'max-lines-per-function': ['error', { max: 150 }] },
  },
  {
    files: ['**/tests/grabber/**/*.ts'],
    rules: {
      // A test is one sequence from its fixture to its last assertion.
      'max-lines-per-function': ['error', { max: 100, skipBlankLines: true, skipComments: true }],
    },
  },
);
