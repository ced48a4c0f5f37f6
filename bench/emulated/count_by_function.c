/* A plugin of qemu-user: counts the instructions that a program runs, and prints a count for each function.
   Debian has no header for plugins, so what it uses is declared here (qemu 7.2, docs/devel/tcg-plugins). */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
enum { kAddToCounter = 0 };
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t,
                                           void (*)(qemu_plugin_id_t, struct qemu_plugin_tb*));
void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn*, int, void*, uint64_t);
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t, void (*)(qemu_plugin_id_t, void*), void*);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb*);
struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb*, size_t);
const char* qemu_plugin_insn_symbol(const struct qemu_plugin_insn*);
void qemu_plugin_outs(const char*);

int qemu_plugin_version = 1;

struct Function {
  char* name;
  uint64_t instructions;
  struct Function* next;
};
static struct Function* table[4096];

static struct Function* find(const char* name) {
  uint32_t hash = 0;
  for (const char* at = name; *at; ++at) hash = hash * 31 + (unsigned char)*at;
  struct Function** link = &table[hash % 4096];
  while (*link && strcmp((*link)->name, name) != 0) link = &(*link)->next;
  if (!*link) {
    *link = calloc(1, sizeof **link);
    (*link)->name = strdup(name);
  }
  return *link;
}

/* Translated code is run many times. It adds to the counters itself, which is exact in a program of one thread.
 */
static void translate(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
  (void)id;
  for (size_t i = 0; i < qemu_plugin_tb_n_insns(block); ++i) {
    struct qemu_plugin_insn* instruction = qemu_plugin_tb_get_insn(block, i);
    const char* name = qemu_plugin_insn_symbol(instruction);
    qemu_plugin_register_vcpu_insn_exec_inline(instruction, kAddToCounter,
                                               &find(name ? name : "?")->instructions, 1);
  }
}

static void print(qemu_plugin_id_t id, void* unused) {
  (void)id, (void)unused;
  for (size_t i = 0; i < sizeof table / sizeof *table; ++i)
    for (const struct Function* function = table[i]; function; function = function->next) {
      char number[32];
      snprintf(number, sizeof number, "%llu ", (unsigned long long)function->instructions);
      qemu_plugin_outs(number);
      qemu_plugin_outs(function->name);
      qemu_plugin_outs("\n");
    }
}

int qemu_plugin_install(qemu_plugin_id_t id, const void* info, int count, char** words) {
  (void)info, (void)count, (void)words;
  qemu_plugin_register_vcpu_tb_trans_cb(id, translate);
  qemu_plugin_register_atexit_cb(id, print, NULL);
  return 0;
}
