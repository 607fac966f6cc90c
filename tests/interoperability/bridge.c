/* Gives a USB device that is offered over USB/IP to the programs below it, without USB in the kernel and without root.
 *
 *     LD_PRELOAD=libumockdev-preload.so.0 bridge PORT BUSID SOCKET PROGRAM [ARGUMENT...]
 *
 * umockdev shows the program a /sys and a /dev with this one device, in that socket of the first bus (1, 2, …), and
 * passes its USBDEVFS ioctls here; each becomes a transfer of USB/IP. Ends with the program's exit status. Sources:
 * linux/usbdevice_fs.h; the kernel's Documentation/usb/usbip_protocol.rst.
 *
 * What a kernel does beyond passing transfers on and keeping two claims apart (reset, drivers, hotplug events) is not here.
 */
#include <arpa/inet.h>
#include <errno.h>
#include <linux/ioctl.h>
#include <linux/usb/ch9.h>
#include <linux/usbdevice_fs.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/wait.h>
#include <umockdev.h>

enum { SUBMIT = 1, UNLINK = 2, SUBMITTED = 3, UNLINKED = 4, HEAD = 48 };

/* A transfer of the program that has not been handed back to it. */
struct transfer {
    uint32_t number;
    UMockdevIoctlClient *owner;
    UMockdevIoctlData *urb;
    UMockdevIoctlData *buffer;
    gboolean ended;
};

static int peer;
static gboolean gone;
static uint32_t last_number;
static GList *transfers;
static UMockdevTestbed *testbed;
static gchar *device_path;
static GMainLoop *loop;
/* Who has the one interface. */
static UMockdevIoctlClient *claimer;

static void fail(const char *what) {
    fprintf(stderr, "bridge: %s\n", what);
    exit(120);
}

static gboolean all(gboolean in, void *bytes, size_t count) {
    for (size_t done = 0; done < count && !gone;) {
        ssize_t now = in ? recv(peer, (char *)bytes + done, count - done, 0)
                         : send(peer, (char *)bytes + done, count - done, MSG_NOSIGNAL);
        if (now <= 0)
            gone = TRUE;
        else
            done += (size_t)now;
    }
    return !gone;
}

static void put(uint8_t *at, uint32_t value) {
    value = htonl(value);
    memcpy(at, &value, 4);
}

static uint32_t get(const uint8_t *at) {
    uint32_t value;
    memcpy(&value, at, 4);
    return ntohl(value);
}

/* Sends a transfer; returns its number. */
static uint32_t submit(uint8_t endpoint, uint32_t flags, const uint8_t *setup, const void *data, uint32_t length) {
    gboolean in = (endpoint & USB_DIR_IN) != 0;
    uint8_t head[HEAD] = {0};
    put(head, SUBMIT);
    put(head + 4, ++last_number);
    put(head + 8, 0x00010002);
    put(head + 12, in);
    put(head + 16, endpoint & 0x7F);
    put(head + 20, flags);
    put(head + 24, length);
    if (setup)
        memcpy(head + 40, setup, 8);
    all(FALSE, head, HEAD);
    if (!in && length)
        all(FALSE, (void *)data, length);
    return last_number;
}

static struct transfer *find(uint32_t number) {
    for (GList *one = transfers; one; one = one->next)
        if (((struct transfer *)one->data)->number == number)
            return one->data;
    return NULL;
}

/* Takes one answer off the stream. Returns the number of the unlink that it ended, 0 for a transfer; its status in *status. */
static uint32_t take(int *status, uint8_t *control, size_t *control_length) {
    uint8_t head[HEAD];
    if (!all(TRUE, head, HEAD))
        return 0;
    uint32_t number = get(head + 4), length = get(head + 24);
    *status = (int)get(head + 20);
    if (get(head) == UNLINKED)
        return number;
    struct transfer *one = find(number);
    if (!one) {
        /* A request of the bridge itself, on endpoint 0 and to the host, or one without data. */
        if (control && length <= *control_length) {
            all(TRUE, control, length);
            *control_length = length;
        }
        return number;
    }
    struct usbdevfs_urb *urb = (struct usbdevfs_urb *)one->urb->data;
    gboolean is_control = urb->type == USBDEVFS_URB_TYPE_CONTROL;
    uint8_t *into = one->buffer ? one->buffer->data + (is_control ? 8 : 0) : NULL;
    gboolean in = is_control ? one->buffer->data[0] & USB_DIR_IN : urb->endpoint & USB_DIR_IN;
    if (in && length) {
        if (length > (uint32_t)urb->buffer_length)
            fail("an answer longer than its buffer");
        all(TRUE, into, length);
    }
    urb->status = *status;
    urb->actual_length = (int)length;
    one->ended = TRUE;
    return 0;
}

/* A request on endpoint 0 by the bridge itself; its status. */
static int control(uint8_t type, uint8_t request, uint16_t value, uint16_t index, uint8_t *data, size_t *length) {
    uint8_t setup[8] = {type, request, value & 0xFF, value >> 8, index & 0xFF, index >> 8, *length & 0xFF, *length >> 8};
    uint32_t number = submit(type & USB_DIR_IN, 0, setup, NULL, type & USB_DIR_IN ? (uint32_t)*length : 0);
    int status = -ENODEV;
    while (!gone && take(&status, type & USB_DIR_IN ? data : NULL, length) != number)
        ;
    return gone ? -ENODEV : status;
}

static void drain(int wait_ms) {
    struct pollfd one = {.fd = peer, .events = POLLIN};
    int status;
    while (!gone && poll(&one, 1, wait_ms) > 0) {
        take(&status, NULL, NULL);
        wait_ms = 0;
    }
}

static gboolean unplugged(gpointer nothing) {
    (void)nothing;
    if (device_path) {
        umockdev_testbed_uevent(testbed, device_path, "remove");
        umockdev_testbed_remove_device(testbed, device_path);
        device_path = NULL;
    }
    return G_SOURCE_REMOVE;
}

static int submit_urb(UMockdevIoctlClient *client, UMockdevIoctlData *data) {
    struct usbdevfs_urb *urb = (struct usbdevfs_urb *)data->data;
    if (gone)
        return -ENODEV;
    struct transfer *one = g_new0(struct transfer, 1);
    one->owner = client;
    one->urb = umockdev_ioctl_data_ref(data);
    if (urb->buffer_length > 0) {
        one->buffer = umockdev_ioctl_data_resolve(data, offsetof(struct usbdevfs_urb, buffer), urb->buffer_length, NULL);
        if (!one->buffer)
            return -EFAULT;
    }
    uint32_t flags = urb->flags & USBDEVFS_URB_SHORT_NOT_OK ? 1 : 0;
    const uint8_t *bytes = one->buffer ? one->buffer->data : NULL;
    if (urb->type == USBDEVFS_URB_TYPE_CONTROL) {
        if (urb->buffer_length < 8)
            return -EINVAL;
        one->number = submit(bytes[0] & USB_DIR_IN, 0, bytes, bytes + 8, urb->buffer_length - 8);
    } else {
        one->number = submit(urb->endpoint, flags, NULL, bytes, urb->buffer_length);
    }
    /* A transfer that was refused must never be handed back: the program has freed it. */
    if (gone) {
        umockdev_ioctl_data_unref(one->urb);
        g_free(one);
        return -ENODEV;
    }
    transfers = g_list_append(transfers, one);
    return 0;
}

/* Gives a transfer up that has not ended. */
static void discard(struct transfer *one) {
    uint8_t head[HEAD] = {0};
    uint32_t number = ++last_number;
    int status;
    put(head, UNLINK);
    put(head + 4, number);
    put(head + 8, 0x00010002);
    put(head + 20, one->number);
    all(FALSE, head, HEAD);
    while (!gone && take(&status, NULL, NULL) != number)
        ;
    if (!one->ended) {
        struct usbdevfs_urb *urb = (struct usbdevfs_urb *)one->urb->data;
        urb->status = -ENOENT;
        urb->actual_length = 0;
        one->ended = TRUE;
    }
}

static int discard_urb(UMockdevIoctlClient *client, gulong address) {
    drain(0);
    for (GList *at = transfers; at; at = at->next) {
        struct transfer *one = at->data;
        if (one->owner == client && one->urb->client_addr == address && !one->ended) {
            discard(one);
            return 0;
        }
    }
    return -EINVAL;
}

/* A program has closed the device: its transfers are given up. */
static void vanished(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer nothing) {
    (void)base, (void)nothing;
    if (claimer == client)
        g_clear_object(&claimer);
    for (GList *at = transfers, *next; at; at = next) {
        struct transfer *one = at->data;
        next = at->next;
        if (one->owner != client)
            continue;
        if (!one->ended)
            discard(one);
        transfers = g_list_delete_link(transfers, at);
        umockdev_ioctl_data_unref(one->urb);
        g_free(one);
    }
}

/* Hands back a transfer that has ended. The mock's file always seems ready, so this waits a little where there is none. */
static int reap(UMockdevIoctlClient *client, UMockdevIoctlData *data) {
    drain(0);
    for (int again = 0; again < 2; again++) {
        for (GList *at = transfers; at; at = at->next) {
            struct transfer *one = at->data;
            if (one->owner != client || (!one->ended && !gone))
                continue;
            if (!one->ended)
                ((struct usbdevfs_urb *)one->urb->data)->status = -ENODEV;
            transfers = g_list_delete_link(transfers, at);
            umockdev_ioctl_data_set_ptr(data, 0, one->urb);
            g_free(one);
            return 0;
        }
        if (again == 0)
            drain(1);
    }
    return gone ? -ENODEV : -EAGAIN;
}

static gboolean claimed_by_another(UMockdevIoctlClient *client) {
    return claimer && claimer != client && umockdev_ioctl_client_get_connected(claimer);
}

static void claim(UMockdevIoctlClient *client) {
    g_object_ref(client);
    g_clear_object(&claimer);
    claimer = client;
}

/* A program that has closed the device is noticed a moment later: whoever wants the interface waits for that. */
static gboolean claim_again(gpointer data) {
    UMockdevIoctlClient *client = data;
    gboolean free = !gone && !claimed_by_another(client);
    if (free)
        claim(client);
    umockdev_ioctl_client_complete(client, free ? 0 : -1, free ? 0 : gone ? ENODEV : EBUSY);
    g_object_unref(client);
    return G_SOURCE_REMOVE;
}

static void claim_later(UMockdevIoctlClient *client) {
    GSource *later = g_timeout_source_new(20);
    g_source_set_callback(later, claim_again, g_object_ref(client), NULL);
    g_source_attach(later, g_main_context_get_thread_default());
    g_source_unref(later);
}

static gboolean handle(UMockdevIoctlBase *base, UMockdevIoctlClient *client, gpointer nothing) {
    (void)base, (void)nothing;
    gulong request = umockdev_ioctl_client_get_request(client);
    UMockdevIoctlData *argument = umockdev_ioctl_client_get_arg(client);
    UMockdevIoctlData *data = NULL;
    size_t none = 0;
    int result = 0;
    if (_IOC_SIZE(request) && request != USBDEVFS_DISCARDURB)
        data = umockdev_ioctl_data_resolve(argument, 0, _IOC_SIZE(request), NULL);
    switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
        *(uint32_t *)data->data = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
        break;
    case USBDEVFS_SUBMITURB:
        result = submit_urb(client, data);
        break;
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
        result = reap(client, data);
        break;
    case USBDEVFS_DISCARDURB:
        result = discard_urb(client, *(gulong *)argument->data);
        break;
    case USBDEVFS_CLEAR_HALT:
        result = control(USB_RECIP_ENDPOINT, USB_REQ_CLEAR_FEATURE, USB_ENDPOINT_HALT, *(unsigned *)data->data, NULL, &none);
        break;
    case USBDEVFS_SETCONFIGURATION:
        result = control(USB_RECIP_DEVICE, USB_REQ_SET_CONFIGURATION, *(unsigned *)data->data, 0, NULL, &none);
        break;
    case USBDEVFS_GETDRIVER:
    case USBDEVFS_IOCTL: /* asks to detach a driver */
        result = -ENODATA;
        break;
    case USBDEVFS_CLAIMINTERFACE:
        if (claimed_by_another(client)) {
            claim_later(client);
            return TRUE;
        }
        claim(client);
        break;
    case USBDEVFS_RELEASEINTERFACE:
        if (claimer != client)
            result = -EINVAL;
        else
            g_clear_object(&claimer);
        break;
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_RESET:
        result = gone ? -ENODEV : 0;
        break;
    default:
        result = -ENOTTY;
    }
    if (gone)
        g_main_context_invoke(NULL, unplugged, NULL);
    umockdev_ioctl_client_complete(client, result < 0 ? -1 : result, result < 0 ? -result : 0);
    return TRUE;
}

static void import_device(int port, const char *name, uint8_t *description) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons(port)};
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    int on = 1;
    peer = socket(AF_INET, SOCK_STREAM, 0);
    if (connect(peer, (struct sockaddr *)&address, sizeof address))
        fail("nobody listens on the port");
    setsockopt(peer, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    uint8_t request[40] = {0x01, 0x11, 0x80, 0x03}, head[8];
    strncpy((char *)request + 8, name, 31);
    all(FALSE, request, sizeof request);
    if (!all(TRUE, head, sizeof head) || get(head + 4) || !all(TRUE, description, 312))
        fail("no such device");
}

static void add_device(const uint8_t *description, int place) {
    uint8_t descriptors[18 + 1024];
    size_t device = 18, rest = 1024;
    if (control(USB_DIR_IN, USB_REQ_GET_DESCRIPTOR, USB_DT_DEVICE << 8, 0, descriptors, &device) ||
        control(USB_DIR_IN, USB_REQ_GET_DESCRIPTOR, USB_DT_CONFIG << 8, 0, descriptors + 18, &rest))
        fail("the device has no descriptors");
    GError *error = NULL;
    /* As umockdev-record writes a device: path, node, attributes (H: binary), properties. The hub of the computer stays. */
    GString *text = g_string_new("P: /devices/usb1\nN: bus/usb/001/001\nE: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\n"
                                 "E: DEVNAME=/dev/bus/usb/001/001\nA: busnum=1\\n\nA: devnum=1\\n\nA: speed=480\\n\n"
                                 "A: bConfigurationValue=1\\n\nA: idVendor=1d6b\\n\nA: idProduct=0002\\n\nH: descriptors="
                                 "12010002090001406B1D020015060302010109021900010100E0000904000001090000000705810304000C\n\n");
    g_string_append_printf(text, "P: /devices/usb1/1-%d\nN: bus/usb/001/%03d\nE: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\n"
                           "E: DEVNAME=/dev/bus/usb/001/%03d\nE: BUSNUM=001\nE: DEVNUM=%03d\nA: busnum=1\\n\nA: devnum=%d\\n\n"
                           "A: bConfigurationValue=1\\n\nA: bNumConfigurations=1\\n\nA: devpath=%d\\n\n",
                           place, place + 1, place + 1, place + 1, place + 1, place);
    g_string_append_printf(text, "A: idVendor=%02x%02x\\n\nA: idProduct=%02x%02x\\n\nA: speed=%s\\n\nH: descriptors=", descriptors[9],
                           descriptors[8], descriptors[11], descriptors[10], get(description + 296) == 3 ? "480" : "12");
    for (size_t at = 0; at < 18 + rest; at++)
        g_string_append_printf(text, "%02X", descriptors[at]);
    /* The device's words, as the kernel keeps them. */
    const char *files[] = {"manufacturer", "product", "serial"};
    for (int which = 0; which < 3; which++) {
        uint8_t words[256];
        size_t length = 255;
        if (!descriptors[14 + which] || control(USB_DIR_IN, USB_REQ_GET_DESCRIPTOR,
                                                (USB_DT_STRING << 8) | descriptors[14 + which], 0x0409, words, &length))
            continue;
        g_string_append_printf(text, "\nA: %s=", files[which]);
        for (size_t at = 2; at + 1 < length; at += 2)
            g_string_append_unichar(text, words[at] | words[at + 1] << 8);
    }
    g_string_append(text, "\n");
    testbed = umockdev_testbed_new();
    if (!umockdev_testbed_add_from_string(testbed, text->str, &error))
        fail(error->message);
    device_path = g_strdup_printf("/sys/devices/usb1/1-%d", place);
    g_autofree gchar *node = g_strdup_printf("/dev/bus/usb/001/%03d", place + 1);
    UMockdevIoctlBase *handler = umockdev_ioctl_base_new();
    g_signal_connect(handler, "handle-ioctl", G_CALLBACK(handle), NULL);
    g_signal_connect(handler, "client-vanished", G_CALLBACK(vanished), NULL);
    if (!umockdev_testbed_attach_ioctl(testbed, node, handler, &error))
        fail(error ? error->message : "the device node cannot be served");
}

static void ended(GPid pid, gint status, gpointer exit_status) {
    (void)pid;
    *(int *)exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    g_main_loop_quit(loop);
}

int main(int count, char **arguments) {
    uint8_t description[312];
    if (count < 5)
        fail("usage: bridge PORT BUSID SOCKET PROGRAM [ARGUMENT...]");
    import_device(atoi(arguments[1]), arguments[2], description);
    add_device(description, atoi(arguments[3]));
    loop = g_main_loop_new(NULL, FALSE);
    GError *error = NULL;
    GPid program;
    int exit_status = 121;
    if (!g_spawn_async(NULL, arguments + 4, NULL, G_SPAWN_DO_NOT_REAP_CHILD | G_SPAWN_SEARCH_PATH | G_SPAWN_CHILD_INHERITS_STDIN,
                       NULL, NULL, &program, &error))
        fail(error->message);
    g_child_watch_add(program, ended, &exit_status);
    g_main_loop_run(loop);
    return exit_status;
}
