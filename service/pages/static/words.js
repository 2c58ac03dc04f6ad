// Sentences of errors in words of a page, as `control_words.py` says them.

/** Labels of the controls that stand for options; any other option is named by its own word. */
const CONTROLS = {
  as: 'The scan is', body: 'Body', labels: 'Labels', wearing: 'Wearing', template: 'Template', units: 'Unit', unit: 'Unit',
  up: 'Up axis', height: 'Height', fabric: 'Fabric', method: 'Method', vertices: 'Quality', redrape: 'Re-drape', paper: 'Paper',
};

/** What of the pages stands for a command; any other one is the operator's. */
const COMMANDS = {
  status: 'the list of jobs', retry: 'Try again', cancel: 'Cancel', export: 'the result\'s page', keys: 'the page Keys',
  templates: 'the page Base patterns', materials: 'the page Fabrics', webhooks: 'the page Webhooks',
};

/** @param {string} option @returns {string} */
function nameControl(option) {
  const words = option.replaceAll('-', ' ');
  return CONTROLS[option] ?? words[0].toUpperCase() + words.slice(1);
}

/** @param {string} message @returns {string} the sentence with controls and pages in place of options and commands */
export function speakOfControls(message) {
  return message.replace(/`garmentq ([a-z]+)[^`]*`/g, (_, command) => COMMANDS[command] ?? 'the operator\'s program')
    .replace(/(?<![\w-])--([a-z]+(?:-[a-z]+)*)/g, (_, option) => `the option ${nameControl(option)}`);
}
