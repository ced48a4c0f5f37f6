// Compiles compute shaders of psplit/webgpu in SPIR-V, as Dawn makes it, by a Vulkan driver, and prints what
// its compiler says of them. Mesa's driver for AMD's GPUs compiles also for a GPU that is not there:
// RADV_FORCE_FAMILY names one.
//
//   spirv_statistics FILE...    prints the device, and a line for each file
#include <stdio.h>
#include <stdlib.h>
#include <vulkan/vulkan.h>

static void check(VkResult result, const char* what) {
  if (result == VK_SUCCESS) return;
  fprintf(stderr, "%s: VkResult %d\n", what, result);
  exit(1);
}

static VkPhysicalDevice first_device(VkInstance instance) {
  VkPhysicalDevice device = VK_NULL_HANDLE;
  uint32_t count = 1;
  vkEnumeratePhysicalDevices(instance, &count, &device);
  if (count == 0) check(VK_ERROR_INITIALIZATION_FAILED, "there is no device");
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(device, &properties);
  printf("%s\n", properties.deviceName);
  return device;
}

// Makes a device with the features that Dawn's SPIR-V asks for.
static VkDevice make_device(VkPhysicalDevice physical) {
  const float priority = 1;
  const VkDeviceQueueCreateInfo queue = {
      .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = &priority};
  VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR statistics = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR,
      .pipelineExecutableInfo = VK_TRUE};
  VkPhysicalDeviceVulkan13Features newer = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
                                            .pNext = &statistics,
                                            .shaderZeroInitializeWorkgroupMemory = VK_TRUE,
                                            .maintenance4 = VK_TRUE};
  VkPhysicalDeviceVulkan12Features features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                               .pNext = &newer,
                                               .vulkanMemoryModel = VK_TRUE,
                                               .vulkanMemoryModelDeviceScope = VK_TRUE};
  const char* const extension = VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME;
  const VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                   .pNext = &features,
                                   .queueCreateInfoCount = 1,
                                   .pQueueCreateInfos = &queue,
                                   .enabledExtensionCount = 1,
                                   .ppEnabledExtensionNames = &extension};
  VkDevice device;
  check(vkCreateDevice(physical, &info, NULL, &device), "vkCreateDevice");
  return device;
}

// The bindings of platform.wgsl.js.
static VkPipelineLayout make_layout(VkDevice device) {
  enum { kBindings = 9 };
  VkDescriptorSetLayoutBinding bindings[kBindings];
  for (uint32_t i = 0; i < kBindings; ++i)
    bindings[i] = (VkDescriptorSetLayoutBinding){
        .binding = i,
        .descriptorType =
            i + 1 < kBindings ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER : VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC,
        .descriptorCount = 1,
        .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
  const VkDescriptorSetLayoutCreateInfo of_set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                  .bindingCount = kBindings,
                                                  .pBindings = bindings};
  VkDescriptorSetLayout set;
  check(vkCreateDescriptorSetLayout(device, &of_set, NULL, &set), "vkCreateDescriptorSetLayout");
  // Dawn passes the lengths of buffers in push constants.
  const VkPushConstantRange range = {.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT, .size = 128};
  const VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                           .setLayoutCount = 1,
                                           .pSetLayouts = &set,
                                           .pushConstantRangeCount = 1,
                                           .pPushConstantRanges = &range};
  VkPipelineLayout layout;
  check(vkCreatePipelineLayout(device, &info, NULL, &layout), "vkCreatePipelineLayout");
  return layout;
}

static VkPipeline compile(VkDevice device, VkPipelineLayout layout, const char* name) {
  enum { kMostWords = 1 << 20 };
  static uint32_t words[kMostWords];
  FILE* const file = fopen(name, "rb");
  if (file == NULL) check(VK_ERROR_UNKNOWN, name);
  const size_t bytes = fread(words, 1, sizeof words, file);
  fclose(file);
  const VkShaderModuleCreateInfo of_module = {
      .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = bytes, .pCode = words};
  VkShaderModule module;
  check(vkCreateShaderModule(device, &of_module, NULL, &module), name);
  const VkComputePipelineCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
      .flags = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR,
      .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                .module = module,
                .pName = "dawn_entry_point"},
      .layout = layout};
  VkPipeline pipeline;
  check(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, NULL, &pipeline), name);
  return pipeline;
}

int main(int argc, char** argv) {
  const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                         .apiVersion = VK_API_VERSION_1_3};
  const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                     .pApplicationInfo = &application};
  VkInstance instance;
  check(vkCreateInstance(&info, NULL, &instance), "vkCreateInstance");
  const VkDevice device = make_device(first_device(instance));
  const PFN_vkGetPipelineExecutableStatisticsKHR get =
      (PFN_vkGetPipelineExecutableStatisticsKHR)vkGetDeviceProcAddr(device,
                                                                    "vkGetPipelineExecutableStatisticsKHR");
  const VkPipelineLayout layout = make_layout(device);
  for (int i = 1; i < argc; ++i) {
    const VkPipelineExecutableInfoKHR of = {.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR,
                                            .pipeline = compile(device, layout, argv[i])};
    VkPipelineExecutableStatisticKHR statistics[64];
    uint32_t count = sizeof statistics / sizeof *statistics;
    for (uint32_t k = 0; k < count; ++k)
      statistics[k] =
          (VkPipelineExecutableStatisticKHR){.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR};
    check(get(device, &of, &count, statistics), argv[i]);
    for (uint32_t k = 0; k < count; ++k)
      printf("%s%s=%llu", k > 0 ? "; " : "", statistics[k].name, (unsigned long long)statistics[k].value.u64);
    printf("\n");
  }
  return 0;
}
