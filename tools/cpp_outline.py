# SPDX-License-Identifier: Apache-2.0
"""An outline of a C++ source: its comments and strings, its classes with their fields and methods, its functions with
their lines and parameters. Reads tokens and brackets, not meanings, which is enough for code in the project's style:

- of `#if … #else … #endif` only the first branch is read, and macros are not expanded;
- `<` opens template arguments when it follows a name and its `>` comes before the end of the statement.
"""
import bisect
import dataclasses
import re

TOKEN = re.compile(
    r'(?P<comment>//[^\n]*|/\*.*?\*/)'
    r'|(?P<directive>^[ \t]*\#(?:\\\n|/(?![/*])|[^\n/\\]|\\(?!\n))*)'
    r'|(?P<string>\b(?:u8|[uUL])?R"(?P<delimiter>[^(\s]*)\(.*?\)(?P=delimiter)"|(?:u8|[uUL])?"(?:\\.|[^"\\\n])*")'
    r"|(?P<number>\.?\d(?:'?[\w.]|(?<=[eEpP])[+-])*)"
    r"|(?P<char>(?:u8|[uUL])?'(?:\\.|[^'\\\n])+')"
    r'|(?P<name>[A-Za-z_]\w*)'
    r'|(?P<symbol>::|->\*?|<=>|<<=?|[<>=!+\-*/%&|^]=|&&|\|\||\+\+|--|\.\.\.|[^\s\w])', re.DOTALL | re.MULTILINE)
DIRECTIVE = re.compile(r'\s*#\s*(\w+)\s*(.*)', re.DOTALL)
INCLUDE = re.compile(r'([<"])([^>"]+)[>"]')
# Names before a parenthesis that is not a list of parameters, and those that are never a function's.
NOT_CALLED = {'requires', 'alignas', 'decltype', 'noexcept', 'explicit', 'sizeof', 'alignof', '__attribute__', 'if', 'while', 'for',
              'switch', 'return', 'catch', 'static_assert'}
ATTRIBUTE_MACRO = re.compile(r'[A-Z]+_[A-Z_]+$')  # GUARDED_BY(mutex_); not SE3(…)
NOT_FIELDS = {'using', 'typedef', 'friend', 'static_assert', 'template', 'extern', 'concept', 'namespace'}  # at the beginning
CLASS_KEYS = {'class', 'struct', 'union'}
OPENING, CLOSING = {'(': ')', '[': ']', '{': '}'}, {')', ']', '}'}


@dataclasses.dataclass
class Token:
    kind: str
    text: str
    line: int


@dataclasses.dataclass
class Comment:
    line: int  # of its first line
    text: str  # without the slashes, a line each


@dataclasses.dataclass
class Class:
    name: str  # with the classes round it: Tracker::Jump
    line: int
    key: str   # class, struct or union
    fields: list = dataclasses.field(default_factory=list)   # names
    methods: list = dataclasses.field(default_factory=list)  # names; without constructors, destructors, defaulted and deleted ones


@dataclasses.dataclass
class Function:
    name: str  # with the classes round it: Tracker::track; "lambda" for those without
    line: int  # where its declaration begins
    lines: int  # to the end of its body; 0: declared only
    local: bool  # of an unnamed namespace
    parameters: list  # a list of token texts each


@dataclasses.dataclass
class Item:
    """A token of a statement, or a bracket with all that is inside."""
    text: str  # of a bracket its two ends: "()", "<>"
    kind: str
    line: int
    first: int
    last: int


def tokenise(text):
    """Returns (tokens without comments and directives, comment tokens with columns, directive tokens)."""
    starts = [0] + [m.end() for m in re.finditer('\n', text)]
    tokens, comments, directives = [], [], []
    skipped = []  # for each open #if whether its present branch is left out
    for match in TOKEN.finditer(text):
        kind, start = match.lastgroup, match.start()
        if kind == 'delimiter':
            kind = 'string'
        line = bisect.bisect_right(starts, start)
        if kind == 'directive':
            word = DIRECTIVE.match(match.group())
            word = word.group(1) if word else ''
            if word in ('if', 'ifdef', 'ifndef'):
                skipped.append(False)
            elif word in ('else', 'elif') and skipped:
                skipped[-1] = True
            elif word == 'endif' and skipped:
                skipped.pop()
            directives.append(Token(kind, match.group(), line))
        elif kind == 'comment':
            column = start - starts[line - 1]
            alone = not text[starts[line - 1]:start].strip()
            comments.append((line, column, alone, match.group()))
        elif not any(skipped):
            tokens.append(Token(kind, match.group(), line))
    return tokens, comments, directives


def gather_comments(found):
    """Runs of // lines are one comment; one behind code is one, with the lines below that begin in its column."""
    comments, last = [], None
    for line, column, alone, text in found:
        if text.startswith('/*'):
            comments.append(Comment(line, text[2:-2].strip()))
            last = None
            continue
        words = re.sub(r'^//[/!]?<? ?', '', text)
        if words.startswith('SPDX-License-Identifier'):
            last = None
            continue
        if last and alone and last == (line - 1, column):
            comments[-1].text += '\n' + words
        else:
            comments.append(Comment(line, words))
        last = (line, column)
    return comments


class Outline:
    def __init__(self, text):
        self.lines = text.count('\n') + (not text.endswith('\n') and text != '')
        self.tokens, found, directives = tokenise(text)
        self.comments = gather_comments(found)
        self.includes = []  # (line, target, in quotes or not)
        for token in directives:
            word, rest = DIRECTIVE.match(token.text).groups() if DIRECTIVE.match(token.text) else ('', '')
            target = word == 'include' and INCLUDE.match(rest)
            if target:
                self.includes.append((token.line, target.group(2), target.group(1) == '"'))
        self.classes, self.functions = [], []
        self._ends = self._match_brackets()
        self._scope(0, len(self.tokens), None, [], False)

    def strings(self):
        """(line, text) of each string; those that follow each other are one."""
        last = None
        for i, token in enumerate(self.tokens):
            if token.kind != 'string':
                continue
            text = token.text[token.text.index('"') + 1:-1]
            if last and last[2] == i - 1:
                last = (last[0], last[1] + '\n' * (token.line - last[3]) + text, i, token.line + text.count('\n'))
                continue
            if last:
                yield last[:2]
            last = (token.line, text, i, token.line + text.count('\n'))
        if last:
            yield last[:2]

    def _match_brackets(self):
        ends, stack = {}, []
        for i, token in enumerate(self.tokens):
            if token.kind != 'symbol':
                continue
            if token.text in OPENING:
                stack.append(i)
            elif token.text in CLOSING:
                while stack and OPENING[self.tokens[stack[-1]].text] != token.text:
                    stack.pop()
                if stack:
                    ends[stack.pop()] = i
        return ends

    def _angle_end(self, i, end):
        """Where the template arguments that `<` at i opens end, or None when it is a comparison."""
        if i == 0 or (self.tokens[i - 1].kind != 'name' or self.tokens[i - 1].text == 'operator') and self.tokens[i - 1].text != ']':
            return None
        depth, j = 0, i
        while j < end:
            text = self.tokens[j].text
            if self.tokens[j].kind == 'symbol':
                if text == '<':
                    depth += 1
                elif text == '>':
                    depth -= 1
                    if depth == 0:
                        return j
                elif text in OPENING and j in self._ends:
                    j = self._ends[j]
                elif text in CLOSING or text in (';', '||'):
                    return None
            j += 1
        return None

    def _item(self, i, end):
        token = self.tokens[i]
        if token.kind == 'symbol':
            if token.text in OPENING and i in self._ends:
                return Item(token.text + OPENING[token.text], 'group', token.line, i, self._ends[i])
            close = self._angle_end(i, end) if token.text == '<' else None
            if close is not None:
                return Item('<>', 'group', token.line, i, close)
        return Item(token.text, token.kind, token.line, i, i)

    def _items(self, begin, end):
        i, items = begin, []
        while i < end:
            items.append(self._item(i, end))
            i = items[-1].last + 1
        return items

    def _scope(self, begin, end, owner, path, local):
        """Reads the declarations of a namespace or, with an owner, of a class."""
        i, head = begin, []
        while i < end:
            item = self._item(i, end)
            i = item.last + 1
            if item.text == ';':
                self._declaration(head, owner, path, local)
                head = []
            elif item.text == ':' and len(head) == 1 and head[0].text in ('public', 'private', 'protected'):
                head = []
            elif item.text == '{}':
                if self._braces(item, head, owner, path, local):
                    head = []
                else:
                    head.append(item)
            else:
                head.append(item)

    def _braces(self, item, head, owner, path, local):
        """Reads what the braces after `head` hold. False: the statement goes on behind them."""
        plain = strip_head(head)
        names = [h.text for h in plain]
        inner = (item.first + 1, item.last)
        if names[:1] == ['namespace'] or names[:2] == ['inline', 'namespace'] or names[:1] == ['extern'] and len(names) == 2:
            self._scope(*inner, None, path, local or names[-1] == 'namespace')
            return True
        key = next((n for n, h in enumerate(plain) if h.text in CLASS_KEYS | {'enum'}), None)
        opened = next((n for n, h in enumerate(plain) if h.text in ('()', '=')), len(plain))
        if key is not None and key < opened:
            if names[key] != 'enum':
                self._class(plain[key:], inner, owner, path, local)
            return False  # up to its ;, with the names of variables
        parameters = parameter_list(plain)
        if parameters is None:
            self._body(*inner, path, local)  # an initialiser; it may hold lambdas
            return False
        after = [h.text for h in plain[parameters + 1:]]
        if ':' in after and plain[-1].text not in ('()', '{}') and plain[-1].text != 'try':
            return False  # a_{1} in a list of initialisers
        self._function(head, plain, parameters, owner, path, local, item)
        for h in head:  # default arguments and initialisers may hold lambdas
            if h.text in ('()', '{}'):
                self._body(h.first + 1, h.last, path, local)
        self._body(*inner, path, local)
        return True

    def _class(self, head, inner, owner, path, local):
        base = next((n for n, h in enumerate(head) if h.text == ':'), len(head))
        names = []  # the last one, with what qualifies it
        for n in range(1, base):
            if head[n].kind == 'name' and head[n].text != 'final':
                names = (names if head[n - 1].text == '::' else []) + [head[n].text]
        if not names:  # its fields are those of the class round it, or of a variable
            name = owner.name + '::(unnamed)' if owner else '(unnamed)'
        else:
            name = '::'.join(path + names)
        made = Class(name, head[0].line, head[0].text)
        self.classes.append(made)
        self._scope(*inner, made, path + names, local)

    def _function(self, head, plain, parameters, owner, path, local, body=None):
        name = called_name(plain, parameters)
        own = owner.name.split('::')[-1] if owner else None
        ending = [h.text for h in plain[parameters + 1:]]
        friend = plain and plain[0].text == 'friend'
        if owner and not friend and name not in (own, '~' + own) and not {'default', 'delete'} & set(ending):
            owner.methods.append(name)
        lists = self._split(plain[parameters].first + 1, plain[parameters].last)
        first = head[0].line
        self.functions.append(Function('::'.join(path + [name]), first, self.tokens[body.last].line - first + 1 if body else 0,
                                       local or 'static' in [h.text for h in plain] and not owner, lists))

    def _split(self, begin, end):
        """Token texts of each part between commas."""
        parts = [[]]
        for item in self._items(begin, end):
            if item.text == ',':
                parts.append([])
            else:
                parts[-1] += [t.text for t in self.tokens[item.first:item.last + 1]]
        return [part for part in parts if part]

    def _declaration(self, head, owner, path, local):
        for h in head:  # initialisers and default arguments may hold lambdas; what braces hold has been read
            if h.text == '[]' and self._is_capture(h.first):
                self._lambda(h.first, h.last + 1, len(self.tokens))
            elif h.text == '()':
                self._body(h.first + 1, h.last, path, local)
        plain = strip_head(head)
        names = [h.text for h in plain]
        if not plain or names[0] in NOT_FIELDS:
            return
        parameters = parameter_list(plain)
        if parameters is not None:
            self._function(head, plain, parameters, owner, path, local)
        elif owner and not ('static' in names and {'constexpr', 'const'} & set(names)):
            self._fields(plain, names, owner)

    def _fields(self, plain, names, owner):
        key = next((n for n, name in enumerate(names) if name in CLASS_KEYS | {'enum'}), None)
        body = names.index('{}') if '{}' in names else None
        if key is None:
            owner.fields += declared_names(plain)
        elif body is None:
            words = [name for name in names[key:] if name not in CLASS_KEYS | {'enum'}]
            if len(words) > 1 and ':' not in words:  # struct timespec now; else a class or enum is declared only
                owner.fields += declared_names(plain)
        elif body + 1 < len(plain):
            owner.fields += declared_names(plain[body + 1:])
        else:
            unnamed = [c for c in self.classes if c.name == owner.name + '::(unnamed)']
            if body == key + 1 and names[key] != 'enum' and unnamed:  # union { int a; float b; };
                owner.fields += unnamed[-1].fields
                self.classes.remove(unnamed[-1])

    def _body(self, begin, end, path, local):
        """Looks through statements for classes and lambdas."""
        i = begin
        while i < end:
            token = self.tokens[i]
            if token.text in CLASS_KEYS and token.kind == 'name' and self.tokens[i - 1].text != 'enum':
                j = i + 1
                while j < end and (self.tokens[j].kind == 'name' or self.tokens[j].text in ('::', ':', ',', '<', '>')):
                    j += 1
                if j < end and self.tokens[j].text == '{' and j in self._ends:
                    self._class(self._items(i, j), (j + 1, self._ends[j]), None, path, local)
                    i = self._ends[j]
            elif token.text == '[' and token.kind == 'symbol' and i in self._ends and self._is_capture(i):
                self._lambda(i, self._ends[i] + 1, end)
            i += 1

    def _is_capture(self, i):
        before, after = self.tokens[i - 1], self.tokens[i + 1].text
        subscript = before.kind == 'name' and before.text not in ('return', 'co_return', 'case') or before.text in (')', ']', '[', '}')
        return not subscript and after != '['

    def _lambda(self, i, j, end):
        if j < end and self.tokens[j].text == '<':
            j = (self._angle_end(j, end) or j) + 1
        if j < end and self.tokens[j].text == '(' and j in self._ends:
            self.functions.append(Function('lambda', self.tokens[i].line, 0, True, self._split(j + 1, self._ends[j])))


def strip_head(head):
    """The statement without template<…>, attributes, alignas(…) and attribute macros."""
    plain, i = [], 0
    while i < len(head):
        text, following = head[i].text, head[i + 1].text if i + 1 < len(head) else ''
        if text == 'template' and following == '<>':
            i += 2
        elif text == '[]' and (not plain or plain[-1].kind != 'name'):
            i += 1
        elif (text in ('alignas', 'requires') or ATTRIBUTE_MACRO.match(text) and plain and plain[-1].text != '~') and following == '()':
            i += 2
        else:
            plain.append(head[i])
            i += 1
    return plain


def parameter_list(plain):
    """Which item of a statement is its list of parameters; None: it declares no function."""
    for n, item in enumerate(plain):
        if item.text == '=' and plain[n - 1].text != 'operator':
            return None
        if item.text != '()' or n == 0:
            continue
        before = plain[n - 1]
        if before.text == 'operator' and n + 1 < len(plain) and plain[n + 1].text == '()':
            continue  # operator()
        operator = any(h.text == 'operator' for h in plain[max(0, n - 4):n])
        if operator or before.text == '<>' or before.kind == 'name' and before.text not in NOT_CALLED:
            pointer = n + 1 < len(plain) and plain[n + 1].text == '()' and not operator  # void (*f)(int)
            return None if pointer else n
    return None


def called_name(plain, parameters):
    """The name before the parameters, with what qualifies it."""
    n, name = parameters - 1, ''
    operator = next((k for k in range(n, max(-1, n - 5), -1) if plain[k].text == 'operator'), None)
    if operator is not None:
        name, n = 'operator' + ' '.join(h.text for h in plain[operator + 1:parameters]), operator - 1
    else:
        if plain[n].text == '<>':
            n -= 1
        name, n = plain[n].text, n - 1
        if n >= 0 and plain[n].text == '~':
            name, n = '~' + name, n - 1
    while n >= 1 and plain[n].text == '::':
        n -= 1
        if plain[n].text == '<>':
            n -= 1
        name, n = plain[n].text + '::' + name, n - 1
    return name


def declared_names(plain):
    """The names that `int a, b[2] = {}, *c{nullptr}, d : 3` declares."""
    parts = [[]]
    for item in plain:
        if item.text == ',':
            parts.append([])
        else:
            parts[-1].append(item)
    names = []
    for part in parts:
        stop = next((n for n, h in enumerate(part) if n and h.text in ('=', '{}', '[]', ':')), len(part))
        words = [h.text for h in part[:stop] if h.kind == 'name']
        names.append(words[-1] if words else '(unnamed)')
    return names
